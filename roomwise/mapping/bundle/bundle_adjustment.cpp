#include "roomwise/mapping/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "roomwise/mapping/bundle/bundle_system.h"
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
    if (!reprojection_residual(view, landmark.point_world, bundle.cameras[view.camera],
                               bundle.model)
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
  if (bundle.fixed == 0 || bundle.fixed > bundle.cameras.size()) {
    return fail("{} of {} cameras are fixed; at least one must be", bundle.fixed,
                bundle.cameras.size());
  }
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i)
    ROOMWISE_CHECK_OK(check_landmark(bundle, i));
  for (const PoseGraphEdge& edge : bundle.edges) {
    if (std::max(edge.from, edge.to) >= bundle.cameras.size() || edge.from == edge.to) {
      return fail("an edge from camera {} to camera {} of {}", edge.from, edge.to,
                  bundle.cameras.size());
    }
  }
  return {};
}

Bundle stepped(const Bundle& bundle, const BundleStep& step) {
  Bundle next = bundle;
  for (std::size_t i = bundle.fixed; i < bundle.cameras.size(); ++i) {
    const auto first = 6 * static_cast<Eigen::Index>(i - bundle.fixed);
    geometry::RigidTransform& pose = next.cameras[i].world_from_camera;
    pose = retract(pose, step.cameras.segment<6>(first));
  }
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i)
    next.landmarks[i].point_world += step.points[i];
  next.model.readout_s += step.readout_s;
  return next;
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
  for (const Landmark& landmark : bundle.landmarks) {
    for (const LandmarkView& view : landmark.views) {
      const Eigen::Vector3d error = reprojection_residual(
          view, landmark.point_world, bundle.cameras[view.camera], bundle.model);
      sum += view_cost(error.squaredNorm(), options.kernel_sigmas).value;
    }
  }
  for (const PoseGraphEdge& edge : bundle.edges) {
    const geometry::Vector6d error =
        edge_error(edge.from_from_to, bundle.cameras[edge.from].world_from_camera,
                   bundle.cameras[edge.to].world_from_camera);
    sum += error.dot(edge.information * error);
  }
  if (options.readout_sigma_s > 0)
    sum += std::pow(bundle.model.readout_s / options.readout_sigma_s, 2);
  return sum;
}

// The damping is Nielsen's, as in pose_graph_solver.
Expected<BundleReport> adjust_bundle(Bundle& bundle, const BundleOptions& options,
                                     const std::function<bool()>& goes_on) {
  constexpr double kFirstDamping = 1e-6;
  constexpr double kMinDamping = 1e-9;
  constexpr double kMaxDamping = 1e9;
  constexpr double kRounding = 1e-10;  // steps of cameras that are so small, m and rad, are none
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_CHECK_OK(check(bundle));
  BundleReport report;
  double current = report.cost_before = report.cost_after = bundle_cost(bundle, options);
  if (bundle.fixed == bundle.cameras.size()) {
    report.converged = true;
    return report;
  }
  BundleSystem system(bundle, options);
  double damping = kFirstDamping;
  double growth = 2;
  bool moved_on = true;
  while (!report.converged && report.iterations < options.max_iterations &&
         damping <= kMaxDamping) {
    if (!goes_on()) {
      report.interrupted = true;
      break;
    }
    ++report.iterations;
    if (std::exchange(moved_on, false)) system.linearize();
    const auto step = system.solve(damping);
    if (!step) {
      damping *= 10;
      continue;
    }
    const bool is_no_step = step->cameras.lpNorm<Eigen::Infinity>() <= kRounding;
    Bundle next = stepped(bundle, *step);
    const double changed = bundle_cost(next, options);
    if (changed <= current) {
      const double ratio =
          step->predicted_reduction > 0 ? (current - changed) / step->predicted_reduction : 1;
      report.converged = is_no_step || current - changed <= options.relative_tolerance * current;
      damping *= std::clamp(1 - std::pow(2 * ratio - 1, 3), 0.1, 2.0);
      damping = std::max(damping, kMinDamping);
      growth = 2;
      bundle = std::move(next);
      current = changed;
      moved_on = true;
    } else {
      report.converged =
          is_no_step || (step->predicted_reduction <= options.relative_tolerance * current &&
                         damping <= kFirstDamping);
      damping *= growth;
      growth *= 2;
    }
  }
  report.cost_after = current;
  return report;
}

std::size_t cull_views(Bundle& bundle, double max_sigmas, std::size_t min_views) {
  std::size_t culled = 0;
  for (Landmark& landmark : bundle.landmarks) {
    culled += std::erase_if(landmark.views, [&](const LandmarkView& view) {
      return !(reprojection_residual(view, landmark.point_world, bundle.cameras[view.camera],
                                     bundle.model)
                   .norm() <= max_sigmas);
    });
  }
  std::erase_if(bundle.landmarks,
                [&](const Landmark& landmark) { return landmark.views.size() < min_views; });
  return culled;
}

}  // namespace roomwise::mapping
