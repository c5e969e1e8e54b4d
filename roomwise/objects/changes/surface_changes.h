#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/objects/changes/changes.h"

// Where depth alone shows that something stands now where nothing was, or the other way round: also
// what no network has a name for.
namespace roomwise::objects {

struct SurfaceChange {
  bool is_new = false;                         // otherwise it is gone
  geometry::OrientedBox box_world;             // upright, about what was seen of it
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells of 5 cm
  FreeSpaceEvidence evidence;                  // of the other walk's depth: gone is looked through
  std::size_t shown_by = 0;                    // the view of its own walk that looks at most of it
};

struct SurfaceChangeOptions {
  double max_range_m = 3.5;  // surface beyond is not measured well enough
  int min_shown = 2;         // views of its own walk that show a cell
  int min_through = 2;       // views of the other walk that look through it
  std::size_t min_cells = 12;
  double min_size_m = 0.12;  // of its longest edge, and half of it of the next

  [[nodiscard]] Expected<void> validate() const;
};

// The patches of surface that the one walk shows again and again and through which the other looks,
// each in one piece; the largest first. What lies on the floor and what either walk did not look at
// is left out. Same input, same result, at any number of threads.
[[nodiscard]] std::vector<SurfaceChange> find_surface_changes(
    std::span<const DepthView> views_before, std::span<const DepthView> views_now,
    const GroundPlane& level, const SurfaceChangeOptions& options, ThreadPool& pool);

}  // namespace roomwise::objects
