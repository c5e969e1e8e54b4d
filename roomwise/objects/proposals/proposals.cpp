#include "roomwise/objects/proposals/proposals.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "roomwise/objects/instances/upright_box.h"
#include "roomwise/objects/instances/world_observation.h"
#include "roomwise/objects/proposals/cell_components.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kNearestDepth_m = 0.3, kFarthestDepth_m = 4.5;
constexpr int kMinShown = 2;                // key-frames
constexpr double kFurnitureReach_m = 2.15;  // above the floor; what crosses it is a wall
constexpr int kWallReach_cells = 2;
constexpr double kFoot_m = 0.08;

// The frame in which the floor is z = 0.
class LevelAxes {
 public:
  explicit LevelAxes(const GroundPlane& level) : floor_m_(level.floor_m) {
    const Vector3d x = level.up_world.unitOrthogonal();
    gravity_from_world_ << x.transpose(), level.up_world.cross(x).transpose(),
        level.up_world.transpose();
  }
  [[nodiscard]] Vector3d from_world(const Vector3d& world) const {
    return gravity_from_world_ * world - Vector3d(0, 0, floor_m_);
  }
  [[nodiscard]] Vector3d to_world(const Vector3d& in_level) const {
    return gravity_from_world_.transpose() * (in_level + Vector3d(0, 0, floor_m_));
  }

 private:
  Eigen::Matrix3d gravity_from_world_;
  double floor_m_;
};

// What the key-frames show, by the cells' keys.
std::vector<LevelCell> cells_of_depth(std::span<const ObservedKeyframe> keyframes,
                                      const LevelAxes& axes) {
  struct Shown {
    int count = 0;
    std::size_t last = 0;  // key-frame, counted from 1
    Vector3f middle;
  };
  std::unordered_map<VoxelKey, Shown> shown;
  constexpr double kMiddle_px = 0.5 * (kCoarseDepthStep_px - 1);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const ObservedKeyframe& keyframe = keyframes[k];
    const image::DepthImage& depth = keyframe.coarse_depth;
    for (int y = 0; y < depth.height(); ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        const double depth_m = depth.at(x, y) / keyframe.camera.depth_units_per_metre;
        if (depth_m < kNearestDepth_m || depth_m > kFarthestDepth_m) continue;
        const Eigen::Vector2d pixel(x * kCoarseDepthStep_px + kMiddle_px,
                                    y * kCoarseDepthStep_px + kMiddle_px);
        const Vector3f point =
            axes.from_world(keyframe.world_from_camera * keyframe.camera.unproject(pixel, depth_m))
                .cast<float>();
        Shown& cell = shown[voxel_of(point, kLevelCell_m)];
        if (cell.last == k + 1) continue;
        cell.last = k + 1;
        if (++cell.count == 1) {
          cell.middle = ((point / kLevelCell_m).array().floor() + 0.5F) * kLevelCell_m;
        }
      }
    }
  }
  std::vector<LevelCell> cells;
  for (const auto& [key, cell] : shown) {
    cells.push_back({key, cell.middle, cell.count});
  }
  std::ranges::sort(cells, {}, &LevelCell::key);
  return cells;
}

// Where walls stand: what is seen right below and right above the height that furniture reaches to.
// A ceiling is not, be it as low as that, unless something as high as a wardrobe stands under it.
std::set<Column> wall_columns(const std::vector<LevelCell>& cells) {
  constexpr double kBand_m = 0.25;
  std::set<Column> below, walls;
  for (const LevelCell& cell : cells) {
    if (cell.height_m() > kFurnitureReach_m || cell.height_m() < kFurnitureReach_m - kBand_m) {
      continue;
    }
    for (const Column& near : columns_about(column_of(cell.middle), 1)) below.insert(near);
  }
  for (const LevelCell& cell : cells) {
    if (cell.height_m() <= kFurnitureReach_m || cell.height_m() > kFurnitureReach_m + kBand_m) {
      continue;
    }
    if (below.contains(column_of(cell.middle))) walls.insert(column_of(cell.middle));
  }
  return walls;
}

// What is neither floor nor wall nor ceiling.
std::vector<LevelCell> standing_cells(const std::vector<LevelCell>& cells,
                                      const std::set<Column>& walls) {
  std::set<Column> near_walls;
  for (const Column& wall : walls) {
    for (const Column& near : columns_about(wall, kWallReach_cells)) near_walls.insert(near);
  }
  std::vector<LevelCell> standing;
  std::ranges::copy_if(cells, std::back_inserter(standing), [&](const LevelCell& cell) {
    return cell.shown >= kMinShown && cell.height_m() > kFoot_m &&
           cell.height_m() <= kFurnitureReach_m && !near_walls.contains(column_of(cell.middle));
  });
  return standing;
}

bool may_be_a_thing(const Vector3d& size_m) {
  constexpr double kMin_m = 0.2, kMax_m = 4;
  return size_m.maxCoeff() >= kMin_m && size_m.head<2>().maxCoeff() <= kMax_m;
}

Proposal proposal_of(const Component& component, const std::vector<LevelCell>& cells,
                     const LevelAxes& axes, const GroundPlane& level) {
  Proposal proposal;
  for (const std::size_t i : component) {
    proposal.surface_world.push_back(axes.to_world(cells[i].middle.cast<double>()).cast<float>());
  }
  proposal.box_world = upright_box(proposal.surface_world, level.up_world);
  proposal.box_world.size_m.array() += static_cast<double>(kLevelCell_m);
  proposal.top_m = level.height_m(proposal.box_world.center()) + proposal.box_world.size_m.z() / 2;
  return proposal;
}

// Where the picture shows the box, were it not cut; absent where a corner is too near.
std::optional<network::PixelBox> projected(const geometry::OrientedBox& box,
                                           const geometry::RigidTransform& camera_from_world,
                                           const geometry::PinholeCamera& camera) {
  constexpr float kFar = std::numeric_limits<float>::max();
  network::PixelBox about{kFar, kFar, -kFar, -kFar};
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d half = 0.5 * box.size_m;
    const Vector3d at((corner & 1) != 0 ? half.x() : -half.x(),
                      (corner & 2) != 0 ? half.y() : -half.y(),
                      (corner & 4) != 0 ? half.z() : -half.z());
    const Vector3d point = camera_from_world * (box.world_from_box * at);
    if (point.z() < kNearestDepth_m) return std::nullopt;
    const Eigen::Vector2f pixel = camera.project_undistorted(point).cast<float>();
    about = {std::min(about.left, pixel.x()), std::min(about.top, pixel.y()),
             std::max(about.right, pixel.x()), std::max(about.bottom, pixel.y())};
  }
  return about;
}

// The share of a proposal's surface that a key-frame shows.
double share_shown(const Proposal& proposal, const ObservedKeyframe& keyframe,
                   const geometry::RigidTransform& camera_from_world) {
  constexpr std::size_t kMaxProbes = 200;
  constexpr double kSame_m = 0.12;
  const std::size_t every = std::max<std::size_t>(1, proposal.surface_world.size() / kMaxProbes);
  int probes = 0, shown = 0;
  for (std::size_t i = 0; i < proposal.surface_world.size(); i += every) {
    ++probes;
    const Vector3d point = camera_from_world * proposal.surface_world[i].cast<double>();
    if (point.z() < kNearestDepth_m) continue;
    const auto depth_m = keyframe.depth_at_m(point);
    if (depth_m && *depth_m > 0 && std::abs(*depth_m - point.z()) < kSame_m) ++shown;
  }
  return static_cast<double>(shown) / probes;
}

}  // namespace

std::vector<Proposal> find_proposals(std::span<const ObservedKeyframe> keyframes,
                                     const GroundPlane& level) {
  const LevelAxes axes(level);
  const std::vector<LevelCell> all = cells_of_depth(keyframes, axes);
  const std::vector<LevelCell> cells = standing_cells(all, wall_columns(all));
  std::vector<Proposal> proposals;
  for (const Component& component : components_above(cells)) {
    Proposal proposal = proposal_of(component, cells, axes, level);
    if (may_be_a_thing(proposal.box_world.size_m)) proposals.push_back(std::move(proposal));
  }
  return proposals;
}

std::vector<ProposalView> best_views(const Proposal& proposal,
                                     std::span<const ObservedKeyframe> keyframes) {
  constexpr std::size_t kMaxViews = 8;
  constexpr float kMinSide_px = 16;
  constexpr double kFarthest_m = 5, kMinInPicture = 0.6, kMinShownShare = 0.35;
  std::vector<ProposalView> views;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const ObservedKeyframe& keyframe = keyframes[k];
    const geometry::RigidTransform camera_from_world = keyframe.world_from_camera.inverse();
    if ((camera_from_world * proposal.box_world.center()).norm() > kFarthest_m) continue;
    const auto whole = projected(proposal.box_world, camera_from_world, keyframe.camera);
    if (!whole) continue;
    const network::PixelBox picture{0, 0, static_cast<float>(keyframe.camera.width),
                                    static_cast<float>(keyframe.camera.height)};
    const network::PixelBox box = network::intersection(*whole, picture);
    const double in_picture = static_cast<double>(box.area() / whole->area());
    if (in_picture < kMinInPicture || box.right - box.left < kMinSide_px ||
        box.bottom - box.top < kMinSide_px) {
      continue;
    }
    const double shown = share_shown(proposal, keyframe, camera_from_world);
    if (shown < kMinShownShare) continue;
    const double size = std::sqrt(static_cast<double>(box.area() / picture.area()));
    views.push_back({k, box, in_picture * shown * size});
  }
  std::ranges::stable_sort(views, std::greater{}, &ProposalView::quality);
  if (views.size() > kMaxViews) views.resize(kMaxViews);
  return views;
}

}  // namespace roomwise::objects
