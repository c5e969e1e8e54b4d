#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/mapping/bundle/reprojection_residual.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// A point of the world that several cameras see.
struct Landmark {
  Eigen::Vector3d point_world = Eigen::Vector3d::Zero();  // m
  std::vector<LandmarkView> views;                        // at most one of each camera
};

// Cameras, what they see, and what is known of their motion besides.
struct Bundle {
  // Of the devices that took the pictures. Only the last one's readout time is found with the rest;
  // what is known of the others' stays as it is.
  std::vector<ViewModel> models{1};
  std::vector<RollingShutterCamera> cameras;
  std::size_t fixed_cameras = 1;  // so many of the first cameras stay where they are
  std::vector<Landmark> landmarks;
  std::vector<PoseGraphEdge> edges;  // between places among the cameras

  [[nodiscard]] const ViewModel& model_of(const RollingShutterCamera& camera) const {
    return models[camera.model];
  }
};

struct BundleOptions {
  // A view whose residual (sigmas) is larger than this counts less and less (Cauchy's kernel).
  double kernel_sigmas = 2.0;
  // The readout time of the last model's rolling shutter is found together with all else, from no
  // more than the expectation that it is of this size, s; 0: it is left as it is.
  double readout_sigma_s = 0.03;
  int max_iterations = 10;
  // Stops when an iteration lowers the cost, or promises to, by less than this part of it.
  double relative_tolerance = 1e-3;

  [[nodiscard]] Expected<void> validate() const;
};

struct BundleReport {
  geometry::MinimizerSummary solver;  // of bundle_cost()
  double rms_px = 0;  // root mean square of how far the views' pixels are from their landmarks
};

// The sum of Cauchy's costs of all views, of e^T Omega e of all edges, and of the readout time's.
[[nodiscard]] double bundle_cost(const Bundle& bundle, const BundleOptions& options);

// Moves cameras and landmarks, and changes the last readout time, to a minimum of bundle_cost() by
// Levenberg and Marquardt's method: landmarks are eliminated (Schur's complement), what stays is
// solved by BlockCholesky (Triggs et al., "Bundle adjustment - a modern synthesis", 2000). Runs on
// one thread and calls no BLAS: same bundle, same bits. Views of points behind their camera must be
// taken out before (cull_views()). `go_on` is asked before each iteration, and where it fails so
// does the work. Fails on a view of a camera, an edge to one or a model that is not there, two
// views of one camera, numbers that are not finite.
[[nodiscard]] Expected<BundleReport> adjust_bundle(
    Bundle& bundle, const BundleOptions& options = {},
    const std::function<Expected<void>()>& go_on = [] { return Expected<void>(); });

// Takes out views whose residual is larger than so many sigmas, and landmarks that are left with
// fewer than `min_views`. The number of views taken out.
std::size_t cull_views(Bundle& bundle, double max_sigmas, std::size_t min_views = 2);

}  // namespace roomwise::mapping
