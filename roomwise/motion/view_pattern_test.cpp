#include "roomwise/motion/view_pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;
using testing::box_room;
using testing::marbled;
using testing::motion_by;
using testing::plain;
using testing::Texture;
using testing::view_of;

const RigidTransform kHere = motion_by({0, 0.1, 0}, {0.1, 0, 0});
const RigidTransform kThere = motion_by({0.02, -0.05, 0.01}, {-0.1, 0.05, 0.1});

PatternCorrelation compared(const Texture& reference, const Texture& current,
                            const RigidTransform& assumed = kHere.inverse() * kThere) {
  const RgbdPyramid a = view_of(box_room(reference), kHere);
  const RgbdPyramid b = view_of(box_room(current), kThere);
  return compare_patterns(a, ViewPattern::of(a), b, ViewPattern::of(b), assumed);
}

TEST(ViewPattern, IsAlikeAtTheRightPoseOnly) {
  EXPECT_GT(compared(marbled, marbled).value(), 0.9);
  const RigidTransform beside = kHere.inverse() * kThere * motion_by({0, 0, 0}, {0.15, 0, 0});
  EXPECT_LT(compared(marbled, marbled, beside).value(), 0.5);
}

TEST(ViewPattern, IsAlikeInAnotherLight) {
  const Texture lamp = [](const Eigen::Vector3d& p) { return (0.3 + 0.1 * p.x()) * marbled(p); };
  EXPECT_GT(compared(marbled, lamp).value(), 0.85);
}

TEST(ViewPattern, OfWhatIsPaintedOtherwiseIsUnlike) {
  const Texture other = [](const Eigen::Vector3d& p) {
    return marbled({-p.y(), 0.7 * p.z(), p.x()});
  };
  EXPECT_LT(std::abs(compared(marbled, other).value()), 0.2);
  const Texture negative = [](const Eigen::Vector3d& p) { return 255 - marbled(p); };
  EXPECT_LT(compared(marbled, negative).value(), -0.9);
}

TEST(ViewPattern, APlainWallIsPlainAndLikeNothing) {
  const RgbdPyramid view = view_of(box_room(plain), kHere);
  EXPECT_THAT(ViewPattern::of(view).even.pixels(), ::testing::Each(128));
  EXPECT_EQ(compared(plain, plain).value(), 0);
  // Noise is no pattern.
  const Texture faint = [](const Eigen::Vector3d& p) { return 130 + 0.01 * (marbled(p) - 130); };
  EXPECT_LT(compared(faint, faint).value(), 0.25);
}

TEST(ViewPattern, PairsOfViewsAddUp) {
  const PatternCorrelation alike = compared(marbled, marbled);
  PatternCorrelation both = alike;
  both += alike;
  EXPECT_DOUBLE_EQ(both.value(), alike.value());
  both += compared(marbled, plain);
  EXPECT_LT(both.value(), alike.value());
}

TEST(ViewPattern, OfNothingIsNothing) {
  EXPECT_TRUE(ViewPattern::of({}).even.pixels().empty());
  const RgbdPyramid view = view_of(box_room(), kHere);
  EXPECT_EQ(compare_patterns({}, {}, view, ViewPattern::of(view), {}).value(), 0);
  EXPECT_EQ(PatternCorrelation{}.value(), 0);
}

}  // namespace
}  // namespace roomwise::motion
