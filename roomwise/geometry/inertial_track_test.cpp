#include "roomwise/geometry/inertial_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roomwise::geometry {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr TimestampNs kStep_ns = 5'000'000;  // 200 a second
const Vector3d kUpWorld(0, 0, 1);

double angle_rad(const Quaterniond& a, const Quaterniond& b) {
  return rotation_vector_rad(a.conjugate() * b).norm();
}

// A camera that turns evenly about an axis of its own, where it stands, tilted at first.
struct Turning {
  Vector3d turning_rad_s{0.3, -0.8, 0.5};
  Quaterniond world_from_first = rotation_by({1.2, 0.1, 0.4});

  [[nodiscard]] Quaterniond world_from_camera(double s) const {
    return world_from_first * rotation_by(s * turning_rad_s);
  }
  [[nodiscard]] InertialSample sample(TimestampNs at_ns) const {
    const auto camera_from_world =
        world_from_camera(static_cast<double>(at_ns) * kSecondsPerNs).conjugate();
    return {at_ns, turning_rad_s, camera_from_world * (kGravity_m_s2 * kUpWorld)};
  }
  [[nodiscard]] std::vector<InertialSample> samples(int count) const {
    std::vector<InertialSample> all;
    for (int i = 0; i < count; ++i) all.push_back(sample(i * kStep_ns));
    return all;
  }
};

TEST(InertialTrack, TurnsAsTheCameraDoes) {
  const Turning camera;
  const InertialTrack track(camera.samples(401), true);
  const auto at = [&](double s) {
    return *track.world_from_camera(static_cast<TimestampNs>(s * 1e9));
  };
  for (const double s : {0.0, 0.0031, 0.7, 1.9999}) {
    EXPECT_LT(angle_rad(at(0.2).conjugate() * at(s),
                        camera.world_from_camera(0.2).conjugate() * camera.world_from_camera(s)),
              1e-9)
        << s;
  }
  EXPECT_TRUE(track.world_from_camera(2'000'000'000));
  EXPECT_FALSE(track.world_from_camera(2'000'000'001)) << "there is no sample behind it";
  EXPECT_FALSE(track.world_from_camera(-1));
}

TEST(InertialTrack, ABiasIsTakenOutOfATurn) {
  const Turning camera;
  const Vector3d bias_rad_s(0.05, -0.03, 0.02);
  std::vector<InertialSample> samples = camera.samples(401);
  for (InertialSample& one : samples) one.turning_rad_s += bias_rad_s;
  const InertialTrack track(samples, true);
  const auto truth = camera.world_from_camera(0.2).conjugate() * camera.world_from_camera(1.4);
  EXPECT_LT(angle_rad(*track.turn(200'000'000, 1'400'000'000, bias_rad_s), truth), 1e-9);
  EXPECT_GT(angle_rad(*track.turn(200'000'000, 1'400'000'000), truth), 0.05);
  EXPECT_FALSE(track.turn(1'400'000'000, 200'000'000));
  EXPECT_FALSE(track.turn(1'400'000'000, 2'000'000'001));
  EXPECT_FALSE(InertialTrack(samples, false).turn(200'000'000, 1'400'000'000));
}

TEST(InertialTrack, UpIsWhereTheForcePointsHoweverItTurns) {
  const Turning camera;
  const InertialTrack track(camera.samples(401), true);
  const auto up = track.up_camera(1'000'000'000);
  ASSERT_TRUE(up);
  EXPECT_LT((camera.world_from_camera(1) * *up - kUpWorld).norm(), 1e-6);
  EXPECT_FALSE(track.up_camera(100'000'000)) << "too little of the second before";
}

// Turned world, same answer: the sensor knows no world.
TEST(InertialTrack, DoesNotDependOnTheWorld) {
  Turning camera, other;
  other.world_from_first = Quaterniond(Eigen::AngleAxisd(2, kUpWorld)) * camera.world_from_first;
  const InertialTrack one(camera.samples(401), true), two(other.samples(401), true);
  EXPECT_LT((*one.up_camera(1'000'000'000) - *two.up_camera(1'000'000'000)).norm(), 1e-9);
  EXPECT_LT(angle_rad(*one.world_from_camera(1'500'000'000), *two.world_from_camera(1'500'000'000)),
            1e-9);
}

TEST(InertialTrack, StepsOfAWalkDoNotTiltUpAndAShakeTellsNothing) {
  Turning camera;
  const auto with = [&](double amplitude_m_s2, double hz) {
    std::vector<InertialSample> samples = camera.samples(401);
    for (InertialSample& one : samples) {
      const double s = static_cast<double>(one.timestamp_ns) * kSecondsPerNs;
      one.force_m_s2 += camera.world_from_camera(s).conjugate() *
                        Vector3d(amplitude_m_s2 * std::sin(2 * std::numbers::pi * hz * s), 0, 0);
    }
    return InertialTrack(samples, true);
  };
  const auto walking = with(1.5, 2).up_camera(1'000'000'000);
  ASSERT_TRUE(walking);
  EXPECT_LT((camera.world_from_camera(1) * *walking - kUpWorld).norm(), 0.01);
  EXPECT_FALSE(with(3, 0.5).up_camera(1'000'000'000)) << "half of that second it is pushed aside";

  std::vector<InertialSample> lifted = camera.samples(401);
  for (InertialSample& one : lifted) one.force_m_s2 *= 1.1;
  EXPECT_FALSE(InertialTrack(lifted, true).up_camera(1'000'000'000));
}

TEST(InertialTrack, AnAccelerometerAloneTellsUpWhereItTurnsSlowly) {
  Turning slow, quick;
  slow.turning_rad_s *= 0.2;
  const InertialTrack track(slow.samples(401), false);
  const auto up = track.up_camera(1'000'000'000);
  ASSERT_TRUE(up);
  EXPECT_LT((slow.world_from_camera(1) * *up - kUpWorld).norm(), 0.01);
  EXPECT_LT((*track.world_from_camera(1'000'000'000) * *up - Vector3d::UnitZ()).norm(), 1e-9);
  quick.turning_rad_s *= 3;
  EXPECT_FALSE(InertialTrack(quick.samples(401), false).up_camera(1'000'000'000));
}

TEST(InertialTrack, AGapBreaksIt) {
  const Turning camera;
  std::vector<InertialSample> samples = camera.samples(401);
  samples.erase(samples.begin() + 200, samples.begin() + 240);  // from 1 to 1.2 s
  const InertialTrack track(samples, true);
  EXPECT_TRUE(track.is_unbroken(0, 990'000'000));
  EXPECT_FALSE(track.is_unbroken(900'000'000, 1'300'000'000));
  EXPECT_TRUE(track.is_unbroken(1'200'000'000, 2'000'000'000));
  EXPECT_FALSE(track.turn(900'000'000, 1'300'000'000));
  EXPECT_FALSE(track.turning_rad_s(1'100'000'000));
  EXPECT_EQ(*track.turning_rad_s(1'300'000'000), camera.turning_rad_s);
  EXPECT_FALSE(track.world_from_camera(1'100'000'000));
  EXPECT_TRUE(track.world_from_camera(1'300'000'000));
  EXPECT_FALSE(track.up_camera(1'300'000'000));
}

TEST(InertialTrack, OfNothingIsNothing) {
  EXPECT_TRUE(InertialTrack().empty());
  for (const std::size_t count : {0U, 1U}) {
    const InertialTrack track(Turning().samples(static_cast<int>(count)), true);
    EXPECT_FALSE(track.world_from_camera(0));
    EXPECT_FALSE(track.up_camera(0));
    EXPECT_FALSE(track.is_unbroken(0, 0));
  }
}

TEST(InertialTrack, RotationVectorsGoToAndFro) {
  for (const Vector3d& vector : {Vector3d(0, 0, 0), Vector3d(1e-9, 0, 0), Vector3d(0.3, -2, 1)})
    EXPECT_LT((rotation_vector_rad(rotation_by(vector)) - vector).norm(), 1e-12);
  Quaterniond other_sign = rotation_by({0.1, 0, 0});
  other_sign.coeffs() *= -1;
  EXPECT_LT((rotation_vector_rad(other_sign) - Vector3d(0.1, 0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace roomwise::geometry
