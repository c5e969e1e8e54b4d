#include "laboratory/simulation/walk/inertial_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using geometry::InertialTrack;

constexpr double kRadius_m = 2, kTurning_rad_s = 0.3;
constexpr InertialSensorOptions kPerfect{.turning_noise_rad_sqrt_s = 0,
                                         .turning_bias_rad_s = 0,
                                         .turning_walk_rad_s_sqrt_s = 0,
                                         .turning_scale = 0,
                                         .force_noise_m_s2_sqrt_s = 0,
                                         .force_bias_m_s2 = 0,
                                         .force_walk_m_s2_sqrt_s = 0};

// Round a table and looking at it, five poses a second: z of the camera ahead, y down.
recording::Trajectory looking_ahead_in_a_circle(int poses) {
  Eigen::Matrix3d world_from_camera;
  world_from_camera << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  recording::Trajectory truth;
  for (int i = 0; i < poses; ++i) {
    const double angle = 0.2 * kTurning_rad_s * i;
    const Quaterniond turn(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    truth.push_back({i * TimestampNs{200'000'000},
                     {turn * Quaterniond(world_from_camera),
                      kRadius_m * Vector3d(std::cos(angle), std::sin(angle), 0)}});
  }
  return truth;
}

TEST(SimulateInertialSensor, FeelsTurnsGravityAndWhatHoldsItOnItsCircle) {
  const auto truth = looking_ahead_in_a_circle(100);
  const InertialTrack track = simulate_inertial_sensor(truth, kPerfect);
  ASSERT_EQ(track.samples().size(), 99U * 40 + 1);
  // Away from the ends, where the spline knows no acceleration.
  for (std::size_t i = 600; i < 3400; ++i) {
    const auto& one = track.samples()[i];
    EXPECT_LT((one.turning_rad_s - Vector3d(0, -kTurning_rad_s, 0)).norm(), 1e-9) << i;
    const Vector3d expected(0, -geometry::kGravity_m_s2,
                            kRadius_m * kTurning_rad_s * kTurning_rad_s);
    EXPECT_LT((one.force_m_s2 - expected).norm(), 1e-3) << i;
  }
}

TEST(SimulateInertialSensor, TheTurnBetweenPicturesIsTheTruth) {
  auto truth = looking_ahead_in_a_circle(60);
  for (std::size_t i = 0; i < truth.size(); ++i) {  // a nodding hand
    truth[i].world_from_camera.rotation =
        truth[i].world_from_camera.rotation *
        geometry::rotation_by({0.1 * std::sin(2.1 * static_cast<double>(i)), 0, 0});
  }
  const InertialTrack track = simulate_inertial_sensor(truth, kPerfect);
  for (std::size_t i = 5; i + 5 < truth.size(); ++i) {
    const auto turn = track.turn(truth[i].timestamp_ns, truth[i + 1].timestamp_ns);
    ASSERT_TRUE(turn);
    const Quaterniond expected =
        truth[i].world_from_camera.rotation.conjugate() * truth[i + 1].world_from_camera.rotation;
    // At a picture the hand turns another way, by up to 1.5 rad/s at once; the sample there has the
    // mean, which is wrong by half of that for half a step.
    EXPECT_LT(geometry::rotation_vector_rad(expected.conjugate() * *turn).norm(), 1.5 * 0.0025)
        << i;
  }
}

TEST(SimulateInertialSensor, ErrsAsItsDataSheetSays) {
  const auto truth = looking_ahead_in_a_circle(60);
  const InertialTrack perfect = simulate_inertial_sensor(truth, kPerfect);
  double bias_squares = 0, noise_squares = 0;
  std::size_t noises = 0;
  constexpr int kSensors = 60;
  for (std::uint64_t seed = 0; seed < kSensors; ++seed) {
    const InertialTrack track = simulate_inertial_sensor(truth, {.seed = seed});
    const auto error = [&](std::size_t i) {
      return Vector3d(track.samples()[i].force_m_s2 - perfect.samples()[i].force_m_s2);
    };
    Vector3d mean = Vector3d::Zero();
    for (std::size_t i = 0; i < 200; ++i) mean += error(i) / 200;
    bias_squares += mean.squaredNorm() / 3;
    for (std::size_t i = 0; i < 200; ++i, ++noises)
      noise_squares += (error(i) - mean).squaredNorm() / 3;
  }
  EXPECT_NEAR(std::sqrt(bias_squares / kSensors), 0.39, 0.07);
  EXPECT_NEAR(std::sqrt(noise_squares / static_cast<double>(noises)), 1.8e-3 * std::sqrt(200.0),
              2e-3);
}

TEST(SimulateInertialSensor, IsTheSameForTheSameSeed) {
  const auto truth = looking_ahead_in_a_circle(10);
  const auto last = [&](std::uint64_t seed) {
    return simulate_inertial_sensor(truth, {.seed = seed}).samples().back().force_m_s2;
  };
  EXPECT_EQ(last(3), last(3));
  EXPECT_NE(last(3), last(4));
}

TEST(SimulateInertialSensor, NamesWhatIsWrong) {
  EXPECT_ERROR(InertialSensorOptions{.rate_hz = 0}.validate(), "rate_hz");
  EXPECT_ERROR(InertialSensorOptions{.force_bias_m_s2 = std::nan("")}.validate(), "errs by");
  EXPECT_TRUE(simulate_inertial_sensor(looking_ahead_in_a_circle(1), {}).empty());
}

}  // namespace
}  // namespace roomwise::simulation
