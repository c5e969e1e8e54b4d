#include "roomwise/mapping/frontend/gyroscope.h"

#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/random.h"

namespace roomwise::mapping {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr TimestampNs kFrame_ns = 200'000'000;
const Vector3d kBias_rad_s(0.05, -0.04, 0.03);

// A camera that looks to and fro for a minute, and its sensor, a hundred samples a second.
Vector3d turning_rad_s(double s) {
  return {0.2 * std::sin(0.7 * s), 0.6 * std::cos(0.4 * s), 0.1};
}
geometry::InertialTrack biased_track() {
  std::vector<geometry::InertialSample> samples;
  for (int i = 0; i <= 6000; ++i)
    samples.push_back({i * TimestampNs{10'000'000}, turning_rad_s(0.01 * i) + kBias_rad_s});
  return {samples, true};
}
Quaterniond truth(const Gyroscope& gyroscope, TimestampNs from_ns, TimestampNs to_ns) {
  return *gyroscope.track().turn(from_ns, to_ns, kBias_rad_s);
}

TEST(Gyroscope, FindsItsBiasFromTheTurnsThatPicturesShow) {
  Gyroscope gyroscope(biased_track());
  const double before = gyroscope.turn(0, kFrame_ns)->sigma_rad;
  RandomStream random(1, {});
  for (int i = 0; i + 1 < 300; ++i) {
    const Vector3d noise(random.normal(), random.normal(), random.normal());
    gyroscope.learn(i * kFrame_ns, (i + 1) * kFrame_ns,
                    truth(gyroscope, i * kFrame_ns, (i + 1) * kFrame_ns) *
                        geometry::rotation_by(0.003 * noise));
  }
  EXPECT_LT((gyroscope.bias_rad_s() - kBias_rad_s).norm(), 0.01);
  EXPECT_LT((gyroscope.bias_rad_s() - kBias_rad_s).norm(), 4 * gyroscope.bias_sigma_rad_s());
  EXPECT_LT(gyroscope.turn(0, kFrame_ns)->sigma_rad, before);
}

TEST(Gyroscope, TurnsThatCannotBeTeachNothing) {
  Gyroscope gyroscope(biased_track());
  for (int i = 0; i < 20; ++i) {
    gyroscope.learn(
        i * kFrame_ns, (i + 1) * kFrame_ns,
        truth(gyroscope, i * kFrame_ns, (i + 1) * kFrame_ns) * geometry::rotation_by({0, 0.5, 0}));
  }
  EXPECT_EQ(gyroscope.bias_rad_s(), Vector3d::Zero());
}

TEST(Gyroscope, ALongPauseOfThePicturesTeachesNothing) {
  Gyroscope gyroscope(biased_track());
  const double before = gyroscope.bias_sigma_rad_s();
  gyroscope.learn(0, 25 * TimestampNs{1'000'000'000}, truth(gyroscope, 0, 25'000'000'000));
  EXPECT_EQ(gyroscope.bias_rad_s(), Vector3d::Zero());
  EXPECT_EQ(gyroscope.bias_sigma_rad_s(), before);
}

TEST(Gyroscope, IsTheLessSureTheLongerAndTheFurtherItTurns) {
  const Gyroscope gyroscope(biased_track());
  const auto sigma = [&](double from_s, double to_s) {
    return gyroscope
        .turn(static_cast<TimestampNs>(from_s * 1e9), static_cast<TimestampNs>(to_s * 1e9))
        ->sigma_rad;
  };
  EXPECT_GT(sigma(10, 11), sigma(10, 10.2));
  EXPECT_GT(sigma(7.5, 8), sigma(3.7, 4.2)) << "quick, slow";
  EXPECT_FALSE(gyroscope.turn(59'000'000'000, 61'000'000'000));
}

// A bias of twice its first sigma is within three of what is told of a step.
TEST(Gyroscope, ABiasThatIsNotKnownYetIsInTheSigma) {
  const Gyroscope gyroscope(biased_track());
  for (int i = 0; i < 290; ++i) {
    const auto turn = gyroscope.turn(i * kFrame_ns, (i + 3) * kFrame_ns);
    const Vector3d error = geometry::rotation_vector_rad(
        truth(gyroscope, i * kFrame_ns, (i + 3) * kFrame_ns).conjugate() * turn->from_from_to);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 3 * turn->sigma_rad) << i;
  }
}

}  // namespace
}  // namespace roomwise::mapping
