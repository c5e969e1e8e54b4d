#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/rgbd_pyramid.h"
#include "roomwise/motion/view_alignment.h"

// The inner part of align_views(): what is compared, and how a pose changes it.
namespace roomwise::motion {

// A point of the reference view, in its camera frame, m, with what it is compared by.
struct SurfacePoint {
  Eigen::Vector3f point;
  Eigen::Vector3f normal;  // zero where there is none
  float gray = 0;
  bool has_normal = false;  // not at an edge, nor seen at a glance
};

// The measured pixels of a view, every `stride`-th of a row (1, 2 or 4), the rows shifted against
// each other.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const PyramidLevel& view, int stride);

// How much brighter the current view is: gray_current = gain * gray_reference + offset.
struct Exposure {
  float gain = 1;
  float offset = 0;
};

// The residuals of all points at a pose, by a twist (omega, v) that moves the reference's points in
// the current frame: p -> exp(omega, v) p.
struct NormalEquations {
  geometry::Matrix6d hessian = geometry::Matrix6d::Zero();
  geometry::Vector6d gradient = geometry::Vector6d::Zero();
  double cost = 0;  // per point; what has no counterpart costs as much as what fits badly
  double squares = 0;
  std::size_t measured = 0;
  Exposure exposure;  // as the pairs of this round show it
};

// Surfaces further apart than `max_correspondence_m` (and their noise) are not the same.
[[nodiscard]] NormalEquations linearize(const std::vector<SurfacePoint>& points,
                                        const PyramidLevel& current,
                                        const geometry::RigidTransform& current_from_reference,
                                        const Exposure& exposure, double max_correspondence_m,
                                        const ViewAlignmentOptions& options);

// What linearize() would say of the exposure, for less.
[[nodiscard]] Exposure find_exposure(const std::vector<SurfacePoint>& points,
                                     const PyramidLevel& current,
                                     const geometry::RigidTransform& current_from_reference,
                                     double max_correspondence_m,
                                     const ViewAlignmentOptions& options);

}  // namespace roomwise::motion
