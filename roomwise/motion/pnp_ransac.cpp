#include "roomwise/motion/pnp_ransac.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/motion/perspective_three_point.h"

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

double reprojection_error2_px2(const PointObservation& observation,
                               const RigidTransform& current_from_reference,
                               const PinholeCamera& camera) {
  const Eigen::Vector3d point = current_from_reference * observation.point_reference;
  if (!(point.z() > 0)) return std::numeric_limits<double>::infinity();
  return (camera.project(point) - observation.pixel_current).squaredNorm();
}

PnpHypothesis score(std::span<const PointObservation> observations,
                    const RigidTransform& current_from_reference, const PinholeCamera& camera,
                    double inlier_px, double cost_to_beat) {
  const double threshold2 = inlier_px * inlier_px;
  PnpHypothesis hypothesis{current_from_reference, camera, 0, 0};
  for (const PointObservation& observation : observations) {
    const double error2 = reprojection_error2_px2(observation, current_from_reference, camera);
    hypothesis.cost += std::min(error2, threshold2);
    if (error2 < threshold2) ++hypothesis.inliers;
    if (hypothesis.cost >= cost_to_beat) break;
  }
  return hypothesis;
}

// How many samples it takes to make it improbable that none was right.
double samples_needed(double right_samples, double confidence) {
  if (right_samples >= 1) return 1;
  return std::log(1 - confidence) / std::log1p(-right_samples);
}

std::array<std::size_t, 3> sample_three(RandomStream& random, std::size_t count) {
  std::array<std::size_t, 3> drawn{};
  do {
    for (std::size_t& index : drawn) index = random.index(count);
  } while (drawn[0] == drawn[1] || drawn[0] == drawn[2] || drawn[1] == drawn[2]);
  return drawn;
}

// Whether two points are about as far apart as the current frame measured them; true where it did
// not. Depth errors grow with the square of the distance.
bool has_same_edge_length(const PointObservation& a, const Eigen::Vector3d& ray_a,
                          const PointObservation& b, const Eigen::Vector3d& ray_b) {
  const double za = a.depth_current_m, zb = b.depth_current_m;
  if (za <= 0 || zb <= 0) return true;
  const double now_m = (ray_a * (za / ray_a.z()) - ray_b * (zb / ray_b.z())).norm();
  const double then_m = (a.point_reference - b.point_reference).norm();
  return std::abs(now_m - then_m) <= 0.03 + 0.015 * (za * za + zb * zb);
}

bool has_same_edge_lengths(const std::array<PointObservation, 3>& sample,
                           const std::array<Eigen::Vector3d, 3>& rays) {
  return has_same_edge_length(sample[0], rays[0], sample[1], rays[1]) &&
         has_same_edge_length(sample[0], rays[0], sample[2], rays[2]) &&
         has_same_edge_length(sample[1], rays[1], sample[2], rays[2]);
}

}  // namespace

PnpHypothesis solve_pnp_ransac(std::span<const PointObservation> observations,
                               const std::function<PinholeCamera(RandomStream&)>& sample_camera,
                               double right_camera, const MotionOptions& options,
                               RandomStream& random) {
  const double max_iterations = options.max_iterations / right_camera;
  PnpHypothesis best;
  double needed = max_iterations;
  for (int iteration = 0; iteration < needed; ++iteration) {
    const auto [i, j, k] = sample_three(random, observations.size());
    const PinholeCamera camera = sample_camera(random);
    const std::array sample{observations[i], observations[j], observations[k]};
    std::array<Eigen::Vector3d, 3> rays;
    std::ranges::transform(sample, rays.begin(), [&](const PointObservation& observation) {
      return camera.unproject(observation.pixel_current, 1.0).normalized();
    });
    if (options.checks_edge_lengths && !has_same_edge_lengths(sample, rays)) continue;
    const std::array points{sample[0].point_reference, sample[1].point_reference,
                            sample[2].point_reference};
    for (const RigidTransform& pose : solve_p3p(points, rays)) {
      const PnpHypothesis hypothesis =
          score(observations, pose, camera, options.inlier_px, best.cost);
      if (hypothesis.cost >= best.cost) continue;
      best = hypothesis;
      const double ratio = best.inliers / static_cast<double>(observations.size());
      needed = std::min(max_iterations,
                        samples_needed(ratio * ratio * ratio * right_camera, options.confidence));
    }
  }
  return best;
}

}  // namespace roomwise::motion
