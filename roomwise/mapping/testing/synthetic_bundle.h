#pragma once

#include <cmath>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/mapping/bundle/bundle_adjustment.h"
#include "roomwise/mapping/graph/edge_error.h"
#include "roomwise/mapping/testing/random_transform.h"

// A made-up scene of landmarks for tests: not part of the product.
namespace roomwise::mapping::testing {

struct SceneOptions {
  std::uint64_t seed = 1;
  std::size_t cameras = 12;
  std::size_t landmarks = 300;
  double noise_sigmas = 0;     // of pixels and disparities
  double without_depth = 0.2;  // this share of the views has none
  double readout_s = 0;
};

// Cameras on an arc that look at a cloud of landmarks 2 to 5 m away; edges between neighbours, as
// the poses are.
class SyntheticScene {
 public:
  explicit SyntheticScene(const SceneOptions& options) : random_(options.seed) {
    truth_.models[0].camera = {500, 500, 319.5, 239.5, 640, 480, {}, 1000};
    truth_.models[0].readout_s = options.readout_s;
    for (std::size_t i = 0; i < options.cameras; ++i) {
      const double angle = 0.06 * static_cast<double>(i);
      RollingShutterCamera& camera = truth_.cameras.emplace_back();
      camera.world_from_camera = {
          Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {0.1 * static_cast<double>(i), 0.05 * std::sin(3 * angle), 0}};
      for (double& value : camera.velocity) value = random_.normal();
    }
    for (std::size_t i = 0; i < options.landmarks; ++i) add_landmark(options);
    for (std::size_t i = 1; i < options.cameras; ++i) {
      truth_.edges.push_back(
          {i - 1, i,
           truth_.cameras[i - 1].world_from_camera.inverse() * truth_.cameras[i].world_from_camera,
           1e4 * geometry::Matrix6d::Identity(), false});
    }
  }

  [[nodiscard]] const Bundle& truth() const { return truth_; }
  // The same with cameras, landmarks and readout time that err.
  [[nodiscard]] Bundle guess(double translation_m = 0.03, double rotation_rad = 0.01) {
    Bundle guess = truth_;
    guess.models[0].readout_s = 0;
    for (std::size_t i = guess.fixed_cameras; i < guess.cameras.size(); ++i) {
      auto& pose = guess.cameras[i].world_from_camera;
      pose = pose * random_transform(random_, translation_m, rotation_rad);
    }
    for (Landmark& landmark : guess.landmarks)
      for (double& value : landmark.point_world) value += 0.03 * random_.normal();
    return guess;
  }

 private:
  void add_landmark(const SceneOptions& options) {
    const auto between = [&](double least, double most) {
      return least + (most - least) * random_.uniform();
    };
    Landmark landmark;
    landmark.point_world = {between(-2, 4), between(-1.5, 1.5), between(2, 5)};
    for (std::uint32_t i = 0; i < truth_.cameras.size(); ++i) {
      const RollingShutterCamera& camera = truth_.cameras[i];
      LandmarkView view{i, {}, 0, 0};
      // The row depends on where the point is seen, and that on the row.
      Eigen::Vector3d seen;
      for (int round = 0; round < 20; ++round) {
        const geometry::RigidTransform world_from_row =
            camera.world_from_camera *
            geometry::RigidTransform::exp(view.row * truth_.models[0].readout_s * camera.velocity);
        seen = world_from_row.inverse() * landmark.point_world;
        view.pixel = truth_.models[0].camera.project_undistorted(seen);
        view.row = view.pixel.y() / (truth_.models[0].camera.height - 1) - 0.5;
      }
      if (!(seen.z() > 0.5) || std::abs(view.row) > 0.5 || view.pixel.x() < 0 ||
          view.pixel.x() > truth_.models[0].camera.width - 1) {
        continue;
      }
      for (double& value : view.pixel) value += options.noise_sigmas * random_.normal();
      const double disparity = truth_.models[0].residuals.focal_baseline_px_m / seen.z() +
                               options.noise_sigmas * random_.normal();
      const bool has_depth = random_.uniform() >= options.without_depth;
      view.depth_m = has_depth ? truth_.models[0].residuals.focal_baseline_px_m / disparity : 0;
      landmark.views.push_back(view);
    }
    if (landmark.views.size() >= 2) truth_.landmarks.push_back(std::move(landmark));
  }

  RandomStream random_;
  Bundle truth_;
};

inline double worst_error_m(const Bundle& found, const Bundle& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.cameras.size(); ++i) {
    worst = std::max(worst, (found.cameras[i].world_from_camera.translation -
                             truth.cameras[i].world_from_camera.translation)
                                .norm());
  }
  return worst;
}

}  // namespace roomwise::mapping::testing
