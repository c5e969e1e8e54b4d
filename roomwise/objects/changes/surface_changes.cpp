#include "roomwise/objects/changes/surface_changes.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/objects/changes/point_votes.h"
#include "roomwise/objects/detection/region_surface.h"
#include "roomwise/objects/instances/upright_box.h"
#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kChangeCell_m = 0.05F;
constexpr double kNearestSurface_m = 0.4;
constexpr int kReach_cells = 2;

// A patch of surface that a walk shows.
struct ShownCell {
  VoxelKey key = 0;
  Vector3d sum = Vector3d::Zero();
  int points = 0;
  int shown = 0;              // views
  std::size_t last_view = 0;  // that showed it, counted from 1
  [[nodiscard]] Vector3f middle() const { return (sum / points).cast<float>(); }
};

// The cells that so many views show, by their keys.
std::vector<ShownCell> cells_shown(std::span<const DepthView> views, const GroundPlane& level,
                                   const SurfaceChangeOptions& options) {
  std::unordered_map<VoxelKey, ShownCell> cells;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const DepthView& view = views[v];
    const int stride = std::max(1, kCoarseDepthStep_px / view.step_px);
    const double middle_px = 0.5 * (view.step_px - 1);
    for (int y = stride / 2; y < view.depth->height(); y += stride) {
      for (int x = stride / 2; x < view.depth->width(); x += stride) {
        const double depth_m = view.depth->at(x, y) / view.camera->depth_units_per_metre;
        if (depth_m < kNearestSurface_m || depth_m > options.max_range_m) continue;
        const Eigen::Vector2d pixel(x * view.step_px + middle_px, y * view.step_px + middle_px);
        const Vector3d point = view.world_from_camera * view.camera->unproject(pixel, depth_m);
        if (level.height_m(point) < kFloorReach_m) continue;
        const Vector3f point_world = point.cast<float>();
        ShownCell& cell = cells[voxel_of(point_world, kChangeCell_m)];
        cell.sum += point;
        ++cell.points;
        if (cell.last_view != v + 1) ++cell.shown;
        cell.last_view = v + 1;
      }
    }
  }
  std::vector<ShownCell> kept;
  for (auto& [key, cell] : cells) {
    if (cell.shown < options.min_shown) continue;
    cell.key = key;
    kept.push_back(cell);
  }
  std::ranges::sort(kept, {}, &ShownCell::key);
  return kept;
}

// Those of the cells that the other walk looks through, and that their own shows in earnest: what
// flies between a thing's rim and the wall behind is seen by a view or two and looked through by
// the rest.
std::vector<ShownCell> changed_cells(std::vector<ShownCell> cells, std::span<const DepthView> own,
                                     std::span<const DepthView> others,
                                     const SurfaceChangeOptions& options, ThreadPool& pool) {
  const auto keep = [&](std::span<const DepthView> views, auto&& wanted) {
    std::vector<Vector3f> middles;
    for (const ShownCell& cell : cells) middles.push_back(cell.middle());
    const PointVotes votes = count_votes(middles, views, pool);
    std::vector<ShownCell> kept;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (wanted(votes.seen[i], votes.through[i])) kept.push_back(cells[i]);
    }
    cells = std::move(kept);
  };
  keep(others,
       [&](int seen, int through) { return through >= options.min_through && through > 2 * seen; });
  keep(own, [&](int seen, int through) { return seen >= options.min_shown && seen > 2 * through; });
  return cells;
}

// Cells that are near each other are one piece: from afar, or at a slant, pictures show fewer
// points of a surface than it has cells.
std::vector<std::vector<Vector3f>> components_of(const std::vector<ShownCell>& cells) {
  DisjointSets sets(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const VoxelKey neighbor : cube_neighbors(cells[i].key, kReach_cells)) {
      const auto at = std::ranges::lower_bound(cells, neighbor, {}, &ShownCell::key);
      if (at == cells.end() || at->key != neighbor) continue;
      sets.join(i, static_cast<std::size_t>(at - cells.begin()));
    }
  }
  std::vector<std::vector<Vector3f>> components(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    components[sets.find(i)].push_back(cells[i].middle());
  std::erase_if(components, [](const auto& component) { return component.empty(); });
  return components;
}

// About the cells of a piece, down to the floor where it begins right above it.
geometry::OrientedBox box_about(std::span<const Vector3f> middles, const GroundPlane& level) {
  constexpr double kStandsBelow_m = 0.15;
  geometry::OrientedBox box = upright_box(middles, level.up_world);
  box.size_m.array() += static_cast<double>(kChangeCell_m);
  const double foot_m = level.height_m(box.center()) - box.size_m.z() / 2;
  if (foot_m > 0 && foot_m < kStandsBelow_m) {
    box.size_m.z() += foot_m;
    box.world_from_box.translation -= foot_m / 2 * level.up_world;
  }
  return box;
}

void add_changes(bool is_new, std::span<const DepthView> own, std::span<const DepthView> others,
                 const GroundPlane& level, const SurfaceChangeOptions& options, ThreadPool& pool,
                 std::vector<SurfaceChange>& changes) {
  const auto cells = changed_cells(cells_shown(own, level, options), own, others, options, pool);
  for (auto& component : components_of(cells)) {
    if (component.size() < options.min_cells) continue;
    SurfaceChange change{is_new, box_about(component, level), std::move(component), {}, 0};
    Vector3d edges = change.box_world.size_m;
    std::ranges::sort(edges);
    if (edges[2] < options.min_size_m || edges[1] < options.min_size_m / 2) continue;
    change.evidence = surface_evidence(change.surface_world, others);
    const auto shown = count_votes(change.surface_world, own).decided_by_view;
    change.shown_by = static_cast<std::size_t>(std::ranges::max_element(shown) - shown.begin());
    changes.push_back(std::move(change));
  }
}

}  // namespace

Expected<void> SurfaceChangeOptions::validate() const {
  if (!(max_range_m > kNearestSurface_m && std::isfinite(max_range_m))) {
    return fail("max_range_m is {}; expected more than {} m", max_range_m, kNearestSurface_m);
  }
  if (min_shown < 1) return fail("min_shown is {}; expected at least 1", min_shown);
  if (min_through < 1) return fail("min_through is {}; expected at least 1", min_through);
  if (!(min_size_m >= 0 && std::isfinite(min_size_m))) {
    return fail("min_size_m is {}; expected 0 m or more", min_size_m);
  }
  return {};
}

std::vector<SurfaceChange> find_surface_changes(std::span<const DepthView> views_before,
                                                std::span<const DepthView> views_now,
                                                const GroundPlane& level,
                                                const SurfaceChangeOptions& options,
                                                ThreadPool& pool) {
  std::vector<SurfaceChange> changes;
  add_changes(false, views_before, views_now, level, options, pool, changes);
  add_changes(true, views_now, views_before, level, options, pool, changes);
  std::ranges::stable_sort(changes, std::ranges::greater(),
                           [](const SurfaceChange& change) { return change.surface_world.size(); });
  return changes;
}

}  // namespace roomwise::objects
