#include "roomwise/mapping/bundle/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/bundle/bundle_problem.h"
#include "roomwise/mapping/testing/synthetic_bundle.h"

namespace roomwise::mapping {
namespace {

using testing::SceneOptions;
using testing::SyntheticScene;
using testing::worst_error_m;

// Until nothing more is to be had.
BundleOptions thorough() {
  BundleOptions options;
  options.max_iterations = 100;
  options.relative_tolerance = 1e-12;
  return options;
}

TEST(AdjustBundle, RecoversASceneWithoutNoise) {
  SyntheticScene scene({});
  Bundle bundle = scene.guess();
  const auto report = adjust_bundle(bundle, thorough());
  ASSERT_OK(report);
  EXPECT_TRUE(report->solver.converged());
  EXPECT_LT(report->solver.final_cost, 1e-6);
  EXPECT_LT(worst_error_m(bundle, scene.truth()), 1e-6);
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i) {
    EXPECT_LT((bundle.landmarks[i].point_world - scene.truth().landmarks[i].point_world).norm(),
              1e-4);
  }
  EXPECT_NEAR(bundle.models[0].readout_s, 0, 1e-6);
}

TEST(AdjustBundle, FindsTheReadoutTimeOfARollingShutter) {
  SyntheticScene scene({.readout_s = 0.025});
  Bundle bundle = scene.guess();
  BundleOptions options = thorough();
  options.readout_sigma_s = 1e3;  // nothing is expected
  ASSERT_OK(adjust_bundle(bundle, options));
  EXPECT_NEAR(bundle.models[0].readout_s, 0.025, 1e-6);
  EXPECT_LT(worst_error_m(bundle, scene.truth()), 1e-5);

  // Taken for a camera that exposes all rows at once, it bends the map.
  Bundle rigid = scene.guess();
  options.readout_sigma_s = 0;
  ASSERT_OK(adjust_bundle(rigid, options));
  EXPECT_EQ(rigid.models[0].readout_s, 0);
  EXPECT_GT(worst_error_m(rigid, scene.truth()), 0.005);
}

TEST(AdjustBundle, IsBetterThanTheEdgesItIsGiven) {
  SyntheticScene scene({.noise_sigmas = 1});
  RandomStream random(3);
  Bundle bundle = scene.truth();
  for (PoseGraphEdge& edge : bundle.edges)
    edge.from_from_to = edge.from_from_to * testing::random_transform(random, 0.01, 0.005);
  for (std::size_t i = 1; i < bundle.cameras.size(); ++i) {
    bundle.cameras[i].world_from_camera =
        bundle.cameras[i - 1].world_from_camera * bundle.edges[i - 1].from_from_to;
  }
  const double by_edges = worst_error_m(bundle, scene.truth());
  ASSERT_OK(adjust_bundle(bundle, thorough()));
  EXPECT_LT(worst_error_m(bundle, scene.truth()), 0.3 * by_edges);
}

TEST(AdjustBundle, IsNotBentByWrongMatches) {
  SyntheticScene scene({.noise_sigmas = 0.5});
  Bundle clean = scene.guess();
  Bundle bundle = clean;
  for (std::size_t i = 0; i < bundle.landmarks.size(); i += 10)
    bundle.landmarks[i].views.back().pixel += Eigen::Vector2d(60, -40);
  ASSERT_OK(adjust_bundle(clean, thorough()));
  ASSERT_OK(adjust_bundle(bundle, thorough()));
  EXPECT_GE(cull_views(bundle, 6), bundle.landmarks.size() / 11);
  ASSERT_OK(adjust_bundle(bundle, thorough()));
  EXPECT_LT(worst_error_m(bundle, clean), 0.005);
  EXPECT_LT(worst_error_m(bundle, scene.truth()), 0.02);
}

TEST(AdjustBundle, NeedsNoDepthWhereTheEdgesTellTheScale) {
  SyntheticScene scene({.without_depth = 1});
  Bundle bundle = scene.guess();
  ASSERT_OK(adjust_bundle(bundle, thorough()));
  EXPECT_LT(worst_error_m(bundle, scene.truth()), 1e-4);
}

TEST(AdjustBundle, HoldsTheFixedCamerasToTheBit) {
  SyntheticScene scene({.noise_sigmas = 1});
  Bundle bundle = scene.guess();
  bundle.fixed_cameras = 3;
  const Bundle before = bundle;
  ASSERT_OK(adjust_bundle(bundle));
  for (std::size_t i = 0; i < bundle.cameras.size(); ++i) {
    const auto& pose = bundle.cameras[i].world_from_camera;
    const auto& was = before.cameras[i].world_from_camera;
    EXPECT_EQ(pose.translation == was.translation, i < bundle.fixed_cameras);
    EXPECT_EQ(pose.rotation.coeffs() == was.rotation.coeffs(), i < bundle.fixed_cameras);
  }
  // With all held, only nothing is left to do.
  bundle.fixed_cameras = bundle.cameras.size();
  const auto report = adjust_bundle(bundle);
  ASSERT_OK(report);
  EXPECT_EQ(report->solver.iterations, 0);
}

TEST(AdjustBundle, SaysHowFarThePixelsAreOff) {
  SyntheticScene scene({.cameras = 4, .landmarks = 50});
  Bundle bundle = scene.truth();
  bundle.fixed_cameras = bundle.cameras.size();
  bundle.models[0].residuals.pixel_sigma_px = 2;
  double views = 0;
  for (const Landmark& landmark : bundle.landmarks)
    views += static_cast<double>(landmark.views.size());
  bundle.landmarks[0].views[0].pixel += Eigen::Vector2d(3, 4);
  const auto report = adjust_bundle(bundle);
  ASSERT_OK(report);
  EXPECT_NEAR(report->rms_px, 5 / std::sqrt(views), 1e-9);
}

TEST(BundleProblem, PredictsWhatADampedStepGains) {
  SyntheticScene scene({.noise_sigmas = 0.1, .readout_s = 0.01});
  Bundle bundle = scene.guess(1e-4, 1e-4);
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i)
    bundle.landmarks[i].point_world =
        scene.truth().landmarks[i].point_world + 1e-3 * Eigen::Vector3d::Ones();
  bundle.models[0].readout_s = 0.009;
  const BundleOptions options{.kernel_sigmas = 1e3};
  BundleProblem problem(bundle, options);
  const double cost = problem.cost();
  problem.linearize();
  for (const double damping : {1e-3, 0.1, 3.0}) {
    const auto step = problem.solve(damping);
    ASSERT_TRUE(step);
    problem.take_step();
    EXPECT_NEAR(cost - problem.cost(), step->predicted_reduction, 0.01 * step->predicted_reduction);
    problem.undo_step();
    EXPECT_EQ(problem.cost(), cost);
  }
}

TEST(AdjustBundle, GivesTheSameBitsAgainAndOnAnotherThread) {
  SyntheticScene scene({.noise_sigmas = 1, .readout_s = 0.01});
  const Bundle guess = scene.guess();
  std::array<Bundle, 2> bundles{guess, guess};
  ASSERT_OK(adjust_bundle(bundles[0]));
  std::thread([&] { ASSERT_OK(adjust_bundle(bundles[1])); }).join();
  EXPECT_EQ(bundles[0].models[0].readout_s, bundles[1].models[0].readout_s);
  for (std::size_t i = 0; i < guess.cameras.size(); ++i) {
    EXPECT_EQ(bundles[0].cameras[i].world_from_camera.translation,
              bundles[1].cameras[i].world_from_camera.translation);
  }
  for (std::size_t i = 0; i < guess.landmarks.size(); ++i)
    EXPECT_EQ(bundles[0].landmarks[i].point_world, bundles[1].landmarks[i].point_world);
}

// ---- beside Ceres, with numeric derivatives and cameras as (rotation vector, translation) ----

geometry::RigidTransform from_numbers(const double* numbers) {
  const Eigen::Vector3d turn(numbers[0], numbers[1], numbers[2]);
  const double angle = turn.norm();
  const Eigen::Quaterniond rotation =
      angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                : Eigen::Quaterniond::Identity();
  return {rotation, {numbers[3], numbers[4], numbers[5]}};
}

struct ViewCost {
  LandmarkView view;
  ViewModel model;
  bool operator()(const double* camera, const double* point, double* residuals) const {
    Eigen::Map<Eigen::Vector3d> error(residuals);
    error =
        reprojection_residual(view, {point[0], point[1], point[2]}, {from_numbers(camera)}, model);
    return error.allFinite();
  }
};
struct EdgeCost {
  PoseGraphEdge edge;  // of information w 1
  bool operator()(const double* from, const double* to, double* residuals) const {
    Eigen::Map<geometry::Vector6d> error(residuals);
    error = std::sqrt(edge.information(0, 0)) *
            edge_error(edge.from_from_to, from_numbers(from), from_numbers(to));
    return true;
  }
};

double optimum_of_ceres(const Bundle& bundle, const BundleOptions& options) {
  std::vector<std::array<double, 6>> cameras;
  for (const RollingShutterCamera& camera : bundle.cameras) {
    const Eigen::AngleAxisd turn(camera.world_from_camera.rotation);
    const Eigen::Vector3d vector = turn.angle() * turn.axis();
    const Eigen::Vector3d& place = camera.world_from_camera.translation;
    cameras.push_back({vector.x(), vector.y(), vector.z(), place.x(), place.y(), place.z()});
  }
  std::vector<Eigen::Vector3d> points;
  for (const Landmark& landmark : bundle.landmarks) points.push_back(landmark.point_world);
  ceres::Problem problem;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const LandmarkView& view : bundle.landmarks[i].views) {
      problem.AddResidualBlock(
          new ceres::NumericDiffCostFunction<ViewCost, ceres::CENTRAL, 3, 6, 3>(
              new ViewCost{view, bundle.models[0]}),
          new ceres::CauchyLoss(options.kernel_sigmas), cameras[view.camera].data(),
          points[i].data());
    }
  }
  for (const PoseGraphEdge& edge : bundle.edges) {
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<EdgeCost, ceres::CENTRAL, 6, 6, 6>(new EdgeCost{edge}),
        nullptr, cameras[edge.from].data(), cameras[edge.to].data());
  }
  for (std::size_t i = 0; i < bundle.fixed_cameras; ++i)
    problem.SetParameterBlockConstant(cameras[i].data());
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = 200;
  solver.function_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return 2 * summary.final_cost;
}

TEST(AdjustBundle, FindsTheOptimumThatCeresFinds) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SyntheticScene scene({.seed = seed, .cameras = 6, .landmarks = 80, .noise_sigmas = 1});
    Bundle bundle = scene.guess();
    for (std::size_t i = 0; i < bundle.landmarks.size(); i += 7)
      bundle.landmarks[i].views.front().pixel += Eigen::Vector2d(25, 10);
    BundleOptions options = thorough();
    options.readout_sigma_s = 0;
    const double expected = optimum_of_ceres(bundle, options);
    const auto report = adjust_bundle(bundle, options);
    ASSERT_OK(report);
    EXPECT_NEAR(report->solver.final_cost, expected, 1e-5 * expected) << "seed " << seed;
  }
}

TEST(CullViews, TakesOutWhatDoesNotFitAndLandmarksSeenOnce) {
  SyntheticScene scene({.cameras = 4, .landmarks = 50});
  Bundle bundle = scene.truth();
  EXPECT_EQ(cull_views(bundle, 1), 0U);
  const std::size_t landmarks = bundle.landmarks.size();
  Landmark& twice = bundle.landmarks[0];
  twice.views.resize(2);
  twice.views[0].pixel.x() += 10;
  bundle.cameras.back().world_from_camera.translation.z() += 100;  // all lies behind it
  EXPECT_GT(cull_views(bundle, 5), 1U);
  EXPECT_LT(bundle.landmarks.size(), landmarks);
  for (const Landmark& landmark : bundle.landmarks) {
    EXPECT_GE(landmark.views.size(), 2U);
    for (const LandmarkView& view : landmark.views) EXPECT_NE(view.camera, 3U);
  }
}

TEST(AdjustBundle, RefusesABrokenBundle) {
  SyntheticScene scene({.cameras = 4, .landmarks = 30});
  const auto after = [&](const auto& change) {
    Bundle bundle = scene.truth();
    change(bundle);
    return adjust_bundle(bundle);
  };
  EXPECT_ERROR(after([](Bundle& b) { b.fixed_cameras = 0; }), "at least one");
  EXPECT_ERROR(after([](Bundle& b) { b.landmarks[3].views[0].camera = 9; }),
               "landmark 3 is seen by camera 9 of 4");
  EXPECT_ERROR(after([](Bundle& b) { b.landmarks[2].views[1] = b.landmarks[2].views[0]; }),
               "seen twice");
  EXPECT_ERROR(after([](Bundle& b) { b.landmarks[1].point_world.z() = -1; }), "in front of");
  EXPECT_ERROR(after([](Bundle& b) { b.edges[0].to = 7; }), "camera 7");
  Bundle bundle = scene.truth();
  EXPECT_ERROR(adjust_bundle(bundle, {.kernel_sigmas = 0}), "kernel_sigmas");
  EXPECT_ERROR(adjust_bundle(bundle, {.max_iterations = 0}), "max_iterations");
}

}  // namespace
}  // namespace roomwise::mapping
