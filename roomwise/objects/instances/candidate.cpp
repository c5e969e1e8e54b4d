#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

#include "roomwise/base/median.h"
#include "roomwise/objects/instances/class_size_prior.h"
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
constexpr double kCommonSigma_m = 0.02;  // of poses and calibration

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

// What the best observations call it.
std::string_view name_of(const ObservationCluster& group,
                         std::span<const WorldObservation> observations) {
  std::map<std::string_view, double> scores;
  for (const std::size_t index : group) {
    scores[observations[index].detection->class_name] += observations[index].weighted_score();
  }
  return std::ranges::max_element(scores, {}, [](const auto& one) { return one.second; })->first;
}

// How high a detector's boxes show a thing to be: the median over those that lie within their
// pictures, each without what they show of the thing's width from above or below. 0 where fewer
// than three do.
double shown_height_m(const ObservationCluster& group,
                      std::span<const WorldObservation> observations,
                      std::span<const ObservedKeyframe> keyframes, const Vector3d& middle_world,
                      double width_m, const Vector3d& up_world) {
  constexpr std::size_t kFewest = 3;
  constexpr float kRim_px = 3;
  constexpr double kNearest_m = 0.3, kMinOfHeight = 0.5;
  std::vector<double> heights_m;
  for (const std::size_t index : group) {
    const Detection& detection = *observations[index].detection;
    const ObservedKeyframe& keyframe = keyframes[observations[index].keyframe];
    const auto picture_height = static_cast<float>(keyframe.camera.height);
    if (detection.source != DetectionSource::kDetector || detection.box.top < kRim_px ||
        detection.box.bottom > picture_height - kRim_px) {
      continue;
    }
    const geometry::RigidTransform camera_from_world = keyframe.world_from_camera.inverse();
    const Vector3d middle = camera_from_world * middle_world;
    if (middle.z() < kNearest_m) continue;
    // By how much of a metre along a direction the picture's rows change, at the middle's depth.
    const auto in_rows = [&](const Vector3d& direction_world) {
      const Vector3d direction = camera_from_world.rotation * direction_world;
      return std::abs(direction.y() - middle.y() / middle.z() * direction.z());
    };
    const Vector3d ray = middle_world - keyframe.world_from_camera.translation;
    const Vector3d ahead = (ray - up_world.dot(ray) * up_world).normalized();
    const double of_height = in_rows(up_world);
    if (of_height < kMinOfHeight) continue;
    const double shown_m = static_cast<double>(detection.box.bottom - detection.box.top) *
                           middle.z() / keyframe.camera.fy;
    heights_m.push_back((shown_m - width_m * in_rows(ahead)) / of_height);
  }
  if (heights_m.size() < kFewest) return 0;
  return median_of(heights_m);
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

// Whether what a classifier says of the picture is said of a box: it holds the middle of the
// picture and a tenth of it or more.
bool stands_in_middle(const network::PixelBox& box, const geometry::PinholeCamera& camera) {
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  return box.left < width / 2 && box.right > width / 2 && box.top < height / 2 &&
         box.bottom > height / 2 && box.area() >= 0.1F * width * height;
}

// The box, how sure its middle is, the surface and whether its size fits.
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
    result.sigma_m[i] =
        std::hypot(jackknife_sigma(kept, group.size(), axes.col(i)), kCommonSigma_m);
  }
  // What begins that low stands on the floor; its foot was cut away with the floor.
  const ClassSizePrior shape = size_prior_of(name_of(group, observations));
  if (shape.on_floor || low.z() - level.floor_m < kStandsBelow_m) {
    low.z() = std::min(level.floor_m, high.z());
  }
  // Of what is small depth may show the foot alone: a bottle is as high as pictures show it to be.
  if (shape.shows_foot_alone && high.z() - low.z() < shape.min_height_m) {
    const double width_m = (high - low).head<2>().maxCoeff();
    const double shown_m =
        shown_height_m(group, observations, keyframes, axes * ((low + high) / 2), width_m, up);
    const double lacks_m = shown_m - (high.z() - low.z());
    if (lacks_m > 0 && shown_m <= shape.max_height_m) {
      high.z() += lacks_m;
      result.sigma_m.z() = std::hypot(result.sigma_m.z(), lacks_m / 2);
    }
  }
  result.fits_size_prior = shape.fits_when_partial(high - low);
  // Away from the cameras, where nobody saw it.
  Vector3d cameras = Vector3d::Zero();
  for (const std::size_t index : group) {
    cameras += keyframes[observations[index].keyframe].world_from_camera.translation /
               static_cast<double>(group.size());
  }
  for (int i = 0; i < 2; ++i) {
    const double lacks_m = shape.min_side_m - (high[i] - low[i]);
    if (lacks_m <= 0) continue;
    const bool camera_is_low = axes.col(i).dot(cameras) < (low[i] + high[i]) / 2;
    (camera_is_low ? high[i] : low[i]) += camera_is_low ? lacks_m : -lacks_m;
    result.sigma_m[i] = std::hypot(result.sigma_m[i], lacks_m / 2);
  }
  result.box_world = {geometry::RigidTransform::from_matrix(axes, axes * ((low + high) / 2)),
                      high - low};
}

}  // namespace

Candidate candidate_of(ObservationCluster group, std::span<const WorldObservation> observations,
                       std::span<const ObservedKeyframe> keyframes, const GroundPlane& level) {
  constexpr double kSaidWeight = 0.5;  // a picture's name is about all of it
  Candidate candidate;
  candidate.group = std::move(group);
  measure(candidate, observations, keyframes, level);
  candidate.voxels = voxels_of(candidate.surface_world, kObservationVoxel_m);
  const geometry::OrientedBox& box = candidate.box_world;
  candidate.foot_m = level.height_m(box.center()) - box.size_m.z() / 2;
  for (const std::size_t index : candidate.group) {
    const WorldObservation& observation = observations[index];
    candidate.source = std::min(candidate.source, observation.detection->source);
    candidate.scores[observation.detection->class_name] += observation.weighted_score();
    const ObservedKeyframe& keyframe = keyframes[observation.keyframe];
    if (!stands_in_middle(observation.detection->box, keyframe.camera)) continue;
    for (const ObjectScore& said : keyframe.said)
      candidate.scores[said.object] += kSaidWeight * said.score;
  }
  return candidate;
}

bool should_see(const ObservedKeyframe& keyframe, std::span<const Eigen::Vector3f> surface_world,
                double max_range_m) {
  constexpr std::size_t kMaxProbes = 60;
  constexpr double kBehind_m = 0.2;
  const std::size_t every = std::max<std::size_t>(1, surface_world.size() / kMaxProbes);
  const geometry::RigidTransform camera_from_world = keyframe.world_from_camera.inverse();
  int probes = 0, visible = 0;
  for (std::size_t i = 0; i < surface_world.size(); i += every) {
    ++probes;
    const Vector3d point = camera_from_world * surface_world[i].cast<double>();
    if (point.z() < 0.3 || point.z() > max_range_m) continue;
    const auto seen_m = keyframe.depth_at_m(point);
    if (seen_m && (*seen_m <= 0 || *seen_m > point.z() - kBehind_m)) ++visible;
  }
  return visible >= 0.7 * probes && probes > 0;
}

}  // namespace roomwise::objects
