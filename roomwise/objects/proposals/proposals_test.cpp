#include "roomwise/objects/proposals/proposals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using testing::TestRoom;

const GroundPlane kLevel{Vector3d::UnitZ(), 0};
const TestRoom::Thing kWardrobe{"wardrobe", {2.58, 0, 1.0}, {0.6, 1.2, 2.0}};  // 12 cm from a wall
const TestRoom::Thing kBed{"bed", {-1.2, 1.2, 0.25}, {1.6, 2.0, 0.5}};
const TestRoom::Thing kNightstand{"table", {-1.2, -1.5, 0.25}, {0.4, 0.4, 0.5}};
const TestRoom::Thing kLamp{"lamp", {-1.2, -1.5, 0.7}, {0.25, 0.25, 0.4}};

// Goes around in the middle of the room, looks at what stands there and up at the walls.
TestRoom seen_from_middle(std::vector<TestRoom::Thing> things) {
  TestRoom room;
  room.things = std::move(things);
  constexpr int kLooks = 36;
  for (int i = 0; i < kLooks; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.3) / kLooks;
    const Vector3d ahead(std::cos(angle), std::sin(angle), 0);
    const Vector3d from = (0.4 + 0.07 * (i % 5)) * ahead + Vector3d(0, 0, 1.4 + 0.05 * (i % 4));
    room.look(from, 3 * ahead + Vector3d(0, 0, 0.6), false);
    room.look(from, 3 * ahead + Vector3d(0, 0, 2.2), false);
    room.look(-2 * ahead + Vector3d(0, 0, 1.5), Vector3d(0, 0, 0.4), false);
    room.look(-2 * ahead + Vector3d(0, 0, 1.5), 3 * ahead + Vector3d(0, 0, 1.6), false);
  }
  return room;
}
// And around each thing.
TestRoom seen_room(std::vector<TestRoom::Thing> things) {
  TestRoom room = seen_from_middle(std::move(things));
  for (const TestRoom::Thing& thing : room.things) {
    for (int i = 0; i < 8; ++i) {
      const double angle = 2 * std::numbers::pi * i / 8;
      const Vector3d from(thing.center.x() + 1.3 * std::cos(angle),
                          thing.center.y() + 1.3 * std::sin(angle), 1.5);
      if (from.cwiseAbs().head<2>().maxCoeff() < 2.9) room.look(from, thing.center, false);
    }
  }
  return room;
}

// The proposal whose box fits the thing best, by the largest difference of middle or size, m.
double misfit_m(const TestRoom::Thing& thing, std::span<const Proposal> proposals) {
  double least = 10;
  for (const Proposal& proposal : proposals) {
    const geometry::OrientedBox& box = proposal.box_world;
    const auto [short_m, long_m] = std::minmax(box.size_m.x(), box.size_m.y());
    const auto [true_short_m, true_long_m] = std::minmax(thing.size_m.x(), thing.size_m.y());
    const double misfit =
        std::max({(box.center() - thing.center).norm(), std::abs(short_m - true_short_m),
                  std::abs(long_m - true_long_m), std::abs(box.size_m.z() - thing.size_m.z())});
    least = std::min(least, misfit);
  }
  return least;
}

TEST(FindProposals, WhatStandsApartIsOne) {
  TestRoom room = seen_room({kWardrobe, kBed, kNightstand, kLamp});
  const auto proposals = find_proposals(room.keyframes(), kLevel);
  EXPECT_LT(misfit_m(kWardrobe, proposals), 0.15) << "though it stands at a wall";
  EXPECT_LT(misfit_m(kBed, proposals), 0.15);
  EXPECT_LT(misfit_m(kLamp, proposals), 0.15) << "above the nightstand's top";
  for (const Proposal& proposal : proposals) {
    const bool is_a_thing = std::ranges::any_of(room.things, [&](const TestRoom::Thing& thing) {
      const geometry::OrientedBox box{{Eigen::Quaterniond::Identity(), thing.center}, thing.size_m};
      return box.distance_m(proposal.box_world.center()) < 0.1;
    });
    EXPECT_TRUE(is_a_thing) << "a wall or the floor was taken for a thing at "
                            << proposal.box_world.center().transpose();
    EXPECT_FALSE(proposal.surface_world.empty());
  }
}

TEST(FindProposals, HangsOnNoOrderOfTheKeyframes) {
  TestRoom room = seen_room({kWardrobe, kBed});
  const auto proposals = find_proposals(room.keyframes(), kLevel);
  std::vector<ObservedKeyframe> reversed(room.keyframes().rbegin(), room.keyframes().rend());
  const auto again = find_proposals(reversed, kLevel);
  ASSERT_EQ(again.size(), proposals.size());
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    EXPECT_EQ(again[i].surface_world, proposals[i].surface_world);
  }
}

TEST(FindProposals, AnEmptyRoomHasNone) {
  TestRoom room = seen_room({});
  EXPECT_THAT(find_proposals(room.keyframes(), kLevel), IsEmpty());
  EXPECT_THAT(find_proposals({}, kLevel), IsEmpty());
}

TEST(FindProposals, WhatStandsUnderALowCeilingIsOne) {
  const TestRoom::Thing ceiling{"", {-1.2, 1.2, 2.35}, {3.0, 3.0, 0.05}};
  TestRoom room = seen_room({kBed, ceiling});
  EXPECT_LT(misfit_m(kBed, find_proposals(room.keyframes(), kLevel)), 0.15);
}

TEST(FindProposals, WhatOneKeyframeAloneShowsIsNone) {
  TestRoom room;
  room.things = {kBed};
  room.look({0.5, -0.5, 1.5}, kBed.center, false);
  EXPECT_THAT(find_proposals(room.keyframes(), kLevel), IsEmpty());
  room.look({0.5, -0.5, 1.5}, kBed.center, false);
  EXPECT_FALSE(find_proposals(room.keyframes(), kLevel).empty());
}

class BestViews : public ::testing::Test {
 protected:
  BestViews() {
    room_.things = {kBox};
    proposal_.box_world = {{Eigen::Quaterniond::Identity(), kBox.center}, kBox.size_m};
    for (double x = -0.25; x < 0.3; x += 0.05) {
      for (double y = -0.25; y < 0.3; y += 0.05) {
        proposal_.surface_world.emplace_back(x, y, kBox.center.z() + kBox.size_m.z() / 2);
      }
    }
  }
  [[nodiscard]] std::vector<ProposalView> views() {
    return best_views(proposal_, room_.keyframes());
  }

  const TestRoom::Thing kBox{"", {0, 0, 0.4}, {0.5, 0.5, 0.8}};
  TestRoom room_;
  Proposal proposal_;
};

TEST_F(BestViews, AreEightAtMostTheBestFirst) {
  room_.look_around(kBox.center, 8, 1.6);
  room_.look_around(kBox.center, 4, 2.6);
  const auto best = views();
  ASSERT_THAT(best, SizeIs(8));
  EXPECT_TRUE(std::ranges::is_sorted(best, std::greater{}, &ProposalView::quality));
  for (const ProposalView& view : best) EXPECT_LT(view.keyframe, 8U) << "the nearer ones";
}

TEST_F(BestViews, HaveTheThingsBox) {
  room_.look({1.6, 0.4, 1.4}, kBox.center);
  const auto best = views();
  ASSERT_THAT(best, SizeIs(1));
  const network::PixelBox& drawn = room_.keyframes()[0].detections.at(0).box;
  EXPECT_GT(network::intersection_over_union(best[0].box, drawn), 0.9F);
}

TEST_F(BestViews, ShowNothingFromBehindOrFromTooNear) {
  room_.things.push_back({"", {1.0, 0, 1.0}, {0.05, 2.0, 2.0}});  // a screen
  room_.look({1.8, 0, 1.4}, kBox.center);
  EXPECT_THAT(views(), IsEmpty()) << "it is hidden";
  room_.look({0.3, 0, 0.9}, {1.3, 0, 0.5});
  EXPECT_THAT(views(), IsEmpty()) << "it reaches behind the camera";
  room_.look({-1.6, 0, 1.4}, {-1.0, 1.2, 1.2});
  EXPECT_THAT(views(), IsEmpty()) << "most of it lies outside of the picture";
  room_.look({-1.6, 0, 1.4}, {-3, 0, 1.4});
  EXPECT_THAT(views(), IsEmpty()) << "it lies behind the camera";
  room_.look({-1.6, 0, 1.4}, kBox.center);
  EXPECT_THAT(views(), SizeIs(1));
}

}  // namespace
}  // namespace roomwise::objects
