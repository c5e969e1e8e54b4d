#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "roomwise/objects/instances/upright_box.h"
#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kCell_m = 0.03F;
constexpr double kHullShare = 0.85;  // of the pictures whose boxes hold a cell
constexpr double kStandsBelow_m = 0.25;
constexpr std::size_t kJackknifeParts = 8;

// A cell of the group's surface: the mean of its points and which observations show it.
struct SurfaceCell {
  Vector3f sum = Vector3f::Zero();
  int points = 0;
  std::vector<std::size_t> shown_by;  // places in the group, ascending

  [[nodiscard]] Vector3f middle() const { return sum / static_cast<float>(points); }
};

std::map<VoxelKey, SurfaceCell> cells_of(const ObservationCluster& group,
                                         std::span<const WorldObservation> observations) {
  std::map<VoxelKey, SurfaceCell> cells;
  for (std::size_t i = 0; i < group.size(); ++i) {
    for (const Vector3f& point : observations[group[i]].points_world) {
      SurfaceCell& cell = cells[voxel_of(point, kCell_m)];
      cell.sum += point;
      ++cell.points;
      if (cell.shown_by.empty() || cell.shown_by.back() != i) cell.shown_by.push_back(i);
    }
  }
  return cells;
}

// Cells that fewer observations show than that are taken for noise: of what most cells of the thing
// are shown by, a share.
std::size_t fewest_shown(const std::map<VoxelKey, SurfaceCell>& cells) {
  constexpr double kOfOften = 0.3;
  std::vector<std::size_t> counts;
  for (const auto& [key, cell] : cells) counts.push_back(cell.shown_by.size());
  if (counts.empty()) return 0;
  const auto often = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() * 9 / 10);
  std::ranges::nth_element(counts, often);
  return static_cast<std::size_t>(kOfOften * static_cast<double>(*often));
}

// Whether a key-frame sees a point, and where in its picture.
std::optional<Eigen::Vector2d> pixel_of(const Vector3f& point_world,
                                        const ObservedKeyframe& keyframe) {
  constexpr double kBehind_m = 0.15;
  const Vector3d point = keyframe.world_from_camera.inverse() * point_world.cast<double>();
  if (point.z() < 0.1) return std::nullopt;
  const auto seen_m = keyframe.depth_at_m(point);
  if (!seen_m || (*seen_m > 0 && *seen_m < point.z() - kBehind_m)) return std::nullopt;
  return keyframe.camera.project(point);
}

// Whether the pictures that show a point show it inside the thing's box: the thing's own points lie
// in nearly all of them, a wall behind it only in those from before it.
bool is_in_hull(const Vector3f& point_world, const ObservationCluster& group,
                std::span<const WorldObservation> observations,
                std::span<const ObservedKeyframe> keyframes) {
  int inside = 0, shown = 0;
  for (const std::size_t index : group) {
    const WorldObservation& observation = observations[index];
    const auto pixel = pixel_of(point_world, keyframes[observation.keyframe]);
    if (!pixel) continue;
    ++shown;
    const network::PixelBox& box = observation.detection->box;
    const double slack = 2 + 0.02 * (box.right - box.left + box.bottom - box.top);
    if (pixel->x() > box.left - slack && pixel->x() < box.right + slack &&
        pixel->y() > box.top - slack && pixel->y() < box.bottom + slack) {
      ++inside;
    }
  }
  return inside >= kHullShare * shown;
}

// How much the middle along an axis hangs on single pictures: the delete-a-group jackknife (Kott,
// Journal of Official Statistics 17, 2001).
double jackknife_sigma(std::span<const SurfaceCell> cells, std::size_t observations,
                       const Vector3d& axis) {
  const std::size_t parts = std::min(kJackknifeParts, observations);
  if (parts < 2) return 0.25;
  std::vector<double> middles;
  for (std::size_t part = 0; part < parts; ++part) {
    std::vector<double> along;
    for (const SurfaceCell& cell : cells) {
      const bool stays = std::ranges::any_of(
          cell.shown_by, [&](std::size_t observation) { return observation % parts != part; });
      if (stays) along.push_back(axis.dot(cell.middle().cast<double>()));
    }
    if (along.empty()) return 0.25;
    const auto [low, high] = range_of(std::move(along));
    middles.push_back((low + high) / 2);
  }
  double mean = 0, squares = 0;
  for (const double middle : middles) mean += middle / static_cast<double>(parts);
  for (const double middle : middles) squares += (middle - mean) * (middle - mean);
  return std::sqrt(squares * static_cast<double>(parts - 1) / static_cast<double>(parts));
}

// The box, how sure its middle is, and the surface.
void measure(Candidate& result, std::span<const WorldObservation> observations,
             std::span<const ObservedKeyframe> keyframes, const GroundPlane& level) {
  const ObservationCluster& group = result.group;
  std::vector<SurfaceCell> kept;
  auto cells = cells_of(group, observations);
  const std::size_t fewest = fewest_shown(cells);
  for (auto& [key, cell] : cells) {
    if (cell.shown_by.size() < fewest) continue;
    if (!is_in_hull(cell.middle(), group, observations, keyframes)) continue;
    result.surface_world.push_back(cell.middle());
    kept.push_back(std::move(cell));
  }
  if (kept.size() < 4) return;
  const Vector3d& up = level.up_world;
  const auto [x, y] = level_axes(result.surface_world, up);
  Eigen::Matrix3d axes;
  axes << x, y, up;
  Vector3d low, high;
  for (int i = 0; i < 3; ++i) {
    std::tie(low[i], high[i]) = range_along(result.surface_world, axes.col(i));
    result.jackknife_m[i] = jackknife_sigma(kept, group.size(), axes.col(i));
  }
  // What begins that low stands on the floor; its foot was cut away with the floor.
  if (level.is_floor_known && low.z() - level.floor_m < kStandsBelow_m) {
    low.z() = std::min(level.floor_m, high.z());
  }
  result.box_world = {geometry::RigidTransform::from_matrix(axes, axes * ((low + high) / 2)),
                      high - low};
}

}  // namespace

double Candidate::extent_m() const {
  constexpr double kMin_m = 0.05;
  return std::cbrt(box_world.size_m.cwiseMax(kMin_m).prod());
}

Candidate candidate_of(ObservationCluster group, std::span<const WorldObservation> observations,
                       std::span<const ObservedKeyframe> keyframes, const GroundPlane& level) {
  Candidate candidate;
  candidate.group = std::move(group);
  candidate.class_name = observations[candidate.group.front()].detection->class_name;
  const auto count = static_cast<double>(candidate.group.size());
  for (const std::size_t i : candidate.group) {
    candidate.middle_world += observations[i].middle_world / count;
  }
  double squares = 0;
  for (const std::size_t i : candidate.group) {
    squares += (observations[i].middle_world - candidate.middle_world).squaredNorm() / count;
  }
  candidate.spread_m = std::sqrt(squares);
  measure(candidate, observations, keyframes, level);
  return candidate;
}

std::vector<Candidate> find_candidates(std::span<const WorldObservation> observations,
                                       std::span<const ObservedKeyframe> keyframes,
                                       const GroundPlane& level) {
  std::vector<Candidate> candidates;
  for (ObservationCluster& group : associate(observations)) {
    const bool is_of_one_picture = std::ranges::all_of(group, [&](std::size_t i) {
      return observations[i].keyframe == observations[group.front()].keyframe;
    });
    if (is_of_one_picture) continue;
    Candidate candidate = candidate_of(std::move(group), observations, keyframes, level);
    if (candidate.has_extent()) candidates.push_back(std::move(candidate));
  }
  return candidates;
}

double share_inside(const geometry::OrientedBox& box, const geometry::OrientedBox& of) {
  constexpr int kSteps = 6;  // a side
  int inside = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Vector3d step(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps));
    const Vector3d place =
        box.size_m.cwiseProduct((step.array() + 0.5).matrix() / kSteps) - box.size_m / 2;
    if (of.distance_m(box.world_from_box * place) == 0) ++inside;
  }
  return static_cast<double>(inside) / (kSteps * kSteps * kSteps);
}

bool should_see(const ObservedKeyframe& keyframe, std::span<const Eigen::Vector3f> surface_world,
                double max_range_m) {
  constexpr std::size_t kMaxProbes = 60;
  constexpr double kBehind_m = 0.2;
  const std::size_t every = std::max<std::size_t>(1, surface_world.size() / kMaxProbes);
  const geometry::RigidTransform camera_from_world = keyframe.world_from_camera.inverse();
  const std::size_t probes = (surface_world.size() + every - 1) / every;
  const auto may_miss = static_cast<std::size_t>(0.3 * static_cast<double>(probes));
  std::size_t missed = 0;
  for (std::size_t i = 0; i < surface_world.size() && missed <= may_miss; i += every) {
    const Vector3d point = camera_from_world * surface_world[i].cast<double>();
    const bool is_in_range = point.z() >= 0.3 && point.z() <= max_range_m;
    const auto seen_m = is_in_range ? keyframe.depth_at_m(point) : std::nullopt;
    if (!seen_m || (*seen_m > 0 && *seen_m <= point.z() - kBehind_m)) ++missed;
  }
  return probes > 0 && missed <= may_miss;
}

}  // namespace roomwise::objects
