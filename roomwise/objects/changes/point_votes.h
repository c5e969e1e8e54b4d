#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/objects/changes/changes.h"

// What depth images say of single points; private to objects/.
namespace roomwise::objects {

// How many views see each point, and how many look through it (see surface_evidence()).
struct PointVotes {
  std::vector<int> seen, through;
  std::vector<std::size_t> decided_by_view;  // points that a view sees or looks through

  [[nodiscard]] bool is_gone(std::size_t point) const { return through[point] > seen[point]; }
};
[[nodiscard]] PointVotes count_votes(std::span<const Eigen::Vector3f> points_world,
                                     std::span<const DepthView> views);
// The same by several threads.
[[nodiscard]] PointVotes count_votes(std::span<const Eigen::Vector3f> points_world,
                                     std::span<const DepthView> views, ThreadPool& pool);

}  // namespace roomwise::objects
