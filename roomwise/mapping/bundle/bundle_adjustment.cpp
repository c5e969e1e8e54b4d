#include "roomwise/mapping/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include "roomwise/mapping/bundle/bundle_problem.h"
#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

Expected<void> check_landmark(const Bundle& bundle, std::size_t index) {
  const Landmark& landmark = bundle.landmarks[index];
  if (!landmark.point_world.allFinite()) return fail("landmark {} is not finite", index);
  std::vector<std::uint32_t> seen;
  for (const LandmarkView& view : landmark.views) {
    if (view.camera >= bundle.cameras.size()) {
      return fail("landmark {} is seen by camera {} of {}", index, view.camera,
                  bundle.cameras.size());
    }
    seen.push_back(view.camera);
    const RollingShutterCamera& camera = bundle.cameras[view.camera];
    if (!reprojection_residual(view, landmark.point_world, camera, bundle.model_of(camera))
             .allFinite()) {
      return fail("landmark {} is not in front of camera {}, or its view is not finite", index,
                  view.camera);
    }
  }
  std::ranges::sort(seen);
  if (std::ranges::adjacent_find(seen) != seen.end())
    return fail("landmark {} is seen twice by one camera", index);
  return {};
}

Expected<void> check(const Bundle& bundle) {
  if (bundle.fixed_cameras == 0 || bundle.fixed_cameras > bundle.cameras.size()) {
    return fail("{} of {} cameras are fixed; at least one must be", bundle.fixed_cameras,
                bundle.cameras.size());
  }
  for (const RollingShutterCamera& camera : bundle.cameras) {
    if (camera.model >= bundle.models.size())
      return fail("a camera is of model {} of {}", camera.model, bundle.models.size());
  }
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i)
    ROOMWISE_RETURN_IF_ERROR(check_landmark(bundle, i));
  for (const PoseGraphEdge& edge : bundle.edges) {
    if (std::max(edge.from, edge.to) >= bundle.cameras.size() || edge.from == edge.to) {
      return fail("an edge from camera {} to camera {} of {}", edge.from, edge.to,
                  bundle.cameras.size());
    }
  }
  return {};
}

template <typename Visit>
void for_each_residual(const Bundle& bundle, const Visit& visit) {
  for (const Landmark& landmark : bundle.landmarks) {
    for (const LandmarkView& view : landmark.views) {
      const RollingShutterCamera& camera = bundle.cameras[view.camera];
      const ViewModel& model = bundle.model_of(camera);
      visit(reprojection_residual(view, landmark.point_world, camera, model), model);
    }
  }
}

double rms_px(const Bundle& bundle) {
  double squares = 0;
  std::size_t views = 0;
  for_each_residual(bundle, [&](const Eigen::Vector3d& error, const ViewModel& model) {
    const double sigma_px = model.residuals.pixel_sigma_px;
    squares += sigma_px * sigma_px * error.head<2>().squaredNorm();
    ++views;
  });
  return views == 0 ? 0 : std::sqrt(squares / static_cast<double>(views));
}

}  // namespace

Expected<void> BundleOptions::validate() const {
  if (!(kernel_sigmas > 0)) return fail("kernel_sigmas = {} must be positive", kernel_sigmas);
  if (!(readout_sigma_s >= 0))
    return fail("readout_sigma_s = {} must not be negative", readout_sigma_s);
  if (max_iterations < 1) return fail("max_iterations = {} must be at least 1", max_iterations);
  if (!(relative_tolerance > 0 && relative_tolerance < 1))
    return fail("relative_tolerance = {} must be between 0 and 1", relative_tolerance);
  return {};
}

double bundle_cost(const Bundle& bundle, const BundleOptions& options) {
  double sum = 0;
  for_each_residual(bundle, [&](const Eigen::Vector3d& error, const ViewModel&) {
    sum += view_loss(error, options).value;
  });
  for (const PoseGraphEdge& edge : bundle.edges) {
    sum += edge_cost(edge, bundle.cameras[edge.from].world_from_camera,
                     bundle.cameras[edge.to].world_from_camera);
  }
  if (options.readout_sigma_s > 0)
    sum += std::pow(bundle.models.back().readout_s / options.readout_sigma_s, 2);
  return sum;
}

Expected<BundleReport> adjust_bundle(Bundle& bundle, const BundleOptions& options,
                                     const std::function<Expected<void>()>& go_on) {
  constexpr double kRounding = 1e-10;  // steps of cameras that are so small, m and rad, are none
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check(bundle));
  BundleReport report;
  if (bundle.fixed_cameras == bundle.cameras.size()) {
    report.solver.initial_cost = report.solver.final_cost = bundle_cost(bundle, options);
  } else {
    BundleProblem problem(bundle, options);
    Expected<void> going;
    report.solver = geometry::minimize(problem,
                                       {.max_iterations = options.max_iterations,
                                        .relative_tolerance = options.relative_tolerance,
                                        .min_step_length = kRounding},
                                       [&] {
                                         going = go_on();
                                         return going.has_value();
                                       });
    ROOMWISE_RETURN_IF_ERROR(going);
  }
  report.rms_px = rms_px(bundle);
  return report;
}

std::size_t cull_views(Bundle& bundle, double max_sigmas, std::size_t min_views) {
  std::size_t culled = 0;
  for (Landmark& landmark : bundle.landmarks) {
    culled += std::erase_if(landmark.views, [&](const LandmarkView& view) {
      const RollingShutterCamera& camera = bundle.cameras[view.camera];
      return !(reprojection_residual(view, landmark.point_world, camera, bundle.model_of(camera))
                   .norm() <= max_sigmas);
    });
  }
  std::erase_if(bundle.landmarks,
                [&](const Landmark& landmark) { return landmark.views.size() < min_views; });
  return culled;
}

}  // namespace roomwise::mapping
