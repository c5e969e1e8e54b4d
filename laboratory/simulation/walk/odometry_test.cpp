#include "laboratory/simulation/walk/odometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

using geometry::RigidTransform;

// Round a table, five poses a second.
recording::Trajectory around_a_table(int poses) {
  recording::Trajectory truth;
  for (int i = 0; i < poses; ++i) {
    const double angle = 0.06 * i;
    truth.push_back({i * TimestampNs{200'000'000},
                     {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                      {2 * std::cos(angle), 2 * std::sin(angle), 1.4}}});
  }
  return truth;
}

double path_m(const recording::Trajectory& trajectory, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i)
    sum += (trajectory[i + 1].world_from_camera.translation -
            trajectory[i].world_from_camera.translation)
               .norm();
  return sum;
}

// How far a stretch leads elsewhere than it did.
double error_m(const recording::Trajectory& truth, const recording::Trajectory& told,
               std::size_t from, std::size_t to) {
  const auto step = [&](const recording::Trajectory& poses) {
    return poses[from].world_from_camera.inverse() * poses[to].world_from_camera;
  };
  return (step(truth).translation - step(told).translation).norm();
}

TEST(SimulateOdometry, DriftsByItsPartOfTheWay) {
  const auto truth = around_a_table(200);
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto told = simulate_odometry(truth, {.seed = seed, .drift = 0.01}).poses;
    ASSERT_EQ(told.size(), truth.size());
    for (std::size_t from = 0; from + 26 < truth.size(); from += 26) {  // half a round, 3.1 m
      const double part = error_m(truth, told, from, from + 26) / path_m(truth, from, from + 26);
      sum += part * part;
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(sum / count), 0.01, 0.006);
}

TEST(SimulateOdometry, IsLevelAndTheSameForTheSameSeed) {
  const auto truth = around_a_table(50);
  const auto one = simulate_odometry(truth, {.seed = 3, .drift = 0.02, .jumps = 2, .dropouts = 1});
  const auto same = simulate_odometry(truth, {.seed = 3, .drift = 0.02, .jumps = 2, .dropouts = 1});
  const auto other =
      simulate_odometry(truth, {.seed = 4, .drift = 0.02, .jumps = 2, .dropouts = 1});
  EXPECT_EQ(recording::trajectory_text(one.poses), recording::trajectory_text(same.poses));
  EXPECT_NE(recording::trajectory_text(one.poses), recording::trajectory_text(other.poses));
  ASSERT_TRUE(one.up);
  for (const auto& pose : one.poses) {
    const Eigen::Vector3d up_camera = pose.world_from_camera.rotation.conjugate() * *one.up;
    EXPECT_GT(up_camera.z(), 0.9999) << "the camera turns about its z alone";
  }
}

TEST(SimulateOdometry, JumpsAndIsSilentAsOftenAsItIsToldTo) {
  const auto truth = around_a_table(300);
  const auto told =
      simulate_odometry(truth, {.seed = 1, .drift = 0, .jumps = 3, .dropouts = 0}).poses;
  int jumps = 0;
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) jumps += error_m(truth, told, i, i + 1) > 0.05;
  EXPECT_EQ(jumps, 3);
  const auto silent =
      simulate_odometry(truth, {.seed = 1, .drift = 0, .jumps = 0, .dropouts = 2}).poses;
  EXPECT_LE(silent.size(), truth.size() - 5);  // of at least a second; they may overlap
  EXPECT_GE(silent.size(), truth.size() - 22);
}

TEST(SimulateOdometry, NamesTheFieldThatIsWrong) {
  EXPECT_ERROR(OdometryOptions{.drift = 2}.validate(), "drift");
  EXPECT_ERROR(OdometryOptions{.drift = std::nan("")}.validate(), "drift");
  EXPECT_ERROR(OdometryOptions{.jumps = -1}.validate(), "jumps");
  EXPECT_TRUE(simulate_odometry({}, {}).poses.empty());
}

}  // namespace
}  // namespace roomwise::simulation
