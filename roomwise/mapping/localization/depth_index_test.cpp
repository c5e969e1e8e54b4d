#include "roomwise/mapping/localization/depth_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::mapping {
namespace {

using motion::testing::box_room;
using motion::testing::marbled;
using motion::testing::motion_by;
using motion::testing::plain;
using motion::testing::view_of;
using motion::testing::wall;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(DepthIndex, FindsTheSameViewFirst) {
  DepthIndex index;
  for (const double yaw : {0.0, 0.5, 1.0, 1.5}) {
    index.add(view_of(box_room(), motion_by({0, yaw, 0}, {0.2, 0, 0.1})));
  }
  const auto hits = index.find(view_of(box_room(), motion_by({0, 1.0, 0}, {0.2, 0, 0.1})), 2);
  ASSERT_THAT(hits, SizeIs(2));
  EXPECT_EQ(hits[0].index, 2u);
  EXPECT_EQ(hits[0].unlike, 0);
  EXPECT_EQ(hits[0].indexed_from_query.angle_rad(), 0);
  EXPECT_GT(hits[1].unlike, 0.05);
}

TEST(DepthIndex, BrightnessIsNothingToIt) {
  DepthIndex index;
  index.add(view_of(box_room(marbled), motion_by({0, 0.3, 0}, {0, 0, 0})));
  const auto hits = index.find(view_of(box_room(plain), motion_by({0, 0.3, 0}, {0, 0, 0})), 1);
  ASSERT_THAT(hits, SizeIs(1));
  EXPECT_EQ(hits[0].unlike, 0);
}

TEST(DepthIndex, SaysHowTheCameraWasTurned) {
  DepthIndex index;
  index.add(view_of(box_room(), motion_by({0, 0.5, 0}, {0.3, 0, 0.2})));
  for (const double turn_rad : {-0.2, 0.2}) {
    const auto hits =
        index.find(view_of(box_room(), motion_by({0, 0.5 + turn_rad, 0}, {0.3, 0, 0.2})), 1);
    ASSERT_THAT(hits, SizeIs(1));
    const auto error =
        motion_by({0, turn_rad, 0}, {0, 0, 0}).inverse() * hits[0].indexed_from_query;
    EXPECT_LT(error.angle_rad(), 0.12) << "turned by " << turn_rad;
  }
}

TEST(DepthIndex, WhatWasNotMeasuredIsLikeNothing) {
  DepthIndex index;
  const auto far_wall = view_of(wall(100), motion_by({0, 0, 0}, {0, 0, 0}));  // beyond all range
  index.add(far_wall);
  index.add(view_of(wall(2), motion_by({0, 0, 0}, {0, 0, 0})));
  const auto hits = index.find(far_wall, 2);
  ASSERT_THAT(hits, SizeIs(2));
  EXPECT_GE(hits[0].unlike, 0.5);
}

TEST(DepthIndex, AnEmptyOneFindsNothing) {
  EXPECT_THAT(DepthIndex().find(view_of(wall(2), motion_by({0, 0, 0}, {0, 0, 0})), 5), IsEmpty());
}

}  // namespace
}  // namespace roomwise::mapping
