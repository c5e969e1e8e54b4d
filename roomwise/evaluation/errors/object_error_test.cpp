#include "roomwise/evaluation/errors/object_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomwise/base/testing/testing.h"

namespace roomwise::evaluation {
namespace {

using geometry::OrientedBox;

// A box of 2 x 1 x 0.5 m, turned about the vertical.
OrientedBox box_at(const Eigen::Vector3d& center, double yaw_rad = 0) {
  return {{Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), center},
          {2, 1, 0.5}};
}

TEST(OrientedBox, MeasuresFromItsSurface) {
  const OrientedBox box = box_at({1, 2, 3}, std::numbers::pi / 2);  // its length along y now
  EXPECT_EQ(box.distance_m({1, 2, 3}), 0);
  EXPECT_NEAR(box.distance_m({1, 2.99, 3}), 0, 1e-12);
  EXPECT_NEAR(box.distance_m({1, 4, 3}), 1, 1e-12);
  EXPECT_NEAR(box.distance_m({2, 2, 3}), 0.5, 1e-12);
  EXPECT_NEAR(box.distance_m({1.5 + 0.3, 2, 3.25 + 0.4}), 0.5, 1e-12) << "from an edge";
}

TEST(ObjectErrors, CountsWhatIsFoundMissedAndWrong) {
  const std::vector<TrueObject> truth{
      {"bed", box_at({0, 0, 0})}, {"lamp", box_at({5, 0, 0})}, {"stove", box_at({0, 9, 0})}};
  const std::vector<FoundObject> found{
      {"bed", {0, 0, 0.25}}, {"lamp", {5, 3, 0}}, {"fridge", {0, 0, 0}}};
  const auto errors = object_errors(truth, found);
  ASSERT_OK(errors);
  ASSERT_EQ(errors->matches.size(), 1U);
  EXPECT_EQ(errors->matches[0].truth, 0U);
  EXPECT_EQ(errors->matches[0].found, 0U);
  EXPECT_EQ(errors->matches[0].from_box_m, 0);
  EXPECT_NEAR(errors->matches[0].from_center_m, 0.25, 1e-12);
  EXPECT_EQ(errors->all.matched, 1U);
  EXPECT_EQ(errors->all.missed, 2U);
  EXPECT_EQ(errors->all.wrong, 2U) << "a lamp 2.5 m from the lamp is no lamp";
  EXPECT_EQ(errors->by_kind.at("lamp").missed, 1U);
  EXPECT_EQ(errors->by_kind.at("lamp").wrong, 1U);
  EXPECT_EQ(errors->by_kind.at("fridge").wrong, 1U);
}

TEST(ObjectErrors, UsesEachThingOnceTheClosestPairFirst) {
  const std::vector<TrueObject> truth{{"chair", box_at({0, 0, 0})}, {"chair", box_at({2.5, 0, 0})}};
  const std::vector<FoundObject> found{{"chair", {1.2, 0, 0}}, {"chair", {1.05, 0, 0}}};
  // The second is 0.05 m from the first chair; the first then belongs to the second chair, 0.3 m
  // away, though the first chair is nearer.
  const auto errors = object_errors(truth, found);
  ASSERT_OK(errors);
  ASSERT_EQ(errors->matches.size(), 2U);
  EXPECT_EQ(errors->matches[0].found, 1U);
  EXPECT_EQ(errors->matches[1].found, 0U);
  EXPECT_NEAR(errors->from_box_quantile_m(0), 0.05, 1e-12);
  EXPECT_NEAR(errors->from_box_quantile_m(0.5), 0.175, 1e-12);
  EXPECT_NEAR(errors->from_box_quantile_m(1), 0.3, 1e-12);
}

TEST(ObjectErrors, AThingFoundTwiceIsADouble) {
  const std::vector<TrueObject> truth{{"chair", box_at({0, 0, 0})}};
  const std::vector<FoundObject> found{
      {"chair", {0, 0, 0}}, {"chair", {1.2, 0, 0}}, {"chair", {4, 0, 0}}};
  const auto errors = object_errors(truth, found);
  ASSERT_OK(errors);
  EXPECT_EQ(errors->all.matched, 1U);
  EXPECT_EQ(errors->all.duplicates, 1U);
  EXPECT_EQ(errors->all.wrong, 1U);
  EXPECT_EQ(errors->all.found(), 3U);
}

TEST(ObjectErrors, WhatIsNotExpectedIsNeitherMissedNorWrong) {
  std::vector<TrueObject> truth{{"stool", box_at({0, 0, 0}), false, {"chair"}},
                                {"lamp", box_at({9, 0, 0}), false, {}}};
  const auto errors = object_errors(truth, std::vector<FoundObject>{{"chair", {0, 0, 0}}});
  ASSERT_OK(errors);
  EXPECT_EQ(errors->all.missed, 0U);
  EXPECT_EQ(errors->all.wrong, 0U);
  EXPECT_EQ(errors->by_kind.at("stool").beyond, 1U);
  truth[0].is_expected = true;
  EXPECT_EQ(object_errors(truth, {})->by_kind.at("stool").missed, 1U);
}

TEST(ObjectErrors, NothingFoundIsNoError) {
  const auto errors = object_errors({}, {});
  ASSERT_OK(errors);
  EXPECT_EQ(errors->from_center_quantile_m(0.9), 0);
  EXPECT_ERROR(object_errors({}, {}, 0), "max_distance_m");
}

}  // namespace
}  // namespace roomwise::evaluation
