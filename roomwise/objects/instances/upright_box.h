#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/objects/instances/instances.h"

// Upright boxes about points.
namespace roomwise::objects {

// The range of values without the outermost 1.5 % on each side, which are taken for noise. Needs a
// value.
[[nodiscard]] std::pair<double, double> range_of(std::vector<double> values);
// The same of points along an axis.
[[nodiscard]] std::pair<double, double> range_along(std::span<const Eigen::Vector3f> points,
                                                    const Eigen::Vector3d& axis);

// The level axes x and y, of unit length, along which the rectangle about the points is smallest.
[[nodiscard]] std::pair<Eigen::Vector3d, Eigen::Vector3d> level_axes(
    std::span<const Eigen::Vector3f> points, const Eigen::Vector3d& up);

// The upright box about the points, by both. Needs a point.
[[nodiscard]] geometry::OrientedBox upright_box(std::span<const Eigen::Vector3f> points,
                                                const Eigen::Vector3d& up);

constexpr double kLeafWidth_m = 1.2;  // of a door, at most

// Whether something upright is as tall, wide and thin as a door's leaf, or a good part of one.
[[nodiscard]] bool is_like_a_leaf(const geometry::OrientedBox& box_world, const GroundPlane& level);

}  // namespace roomwise::objects
