#include "roomwise/live/view/home_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/red_finder.h"
#include "roomwise/pipeline/testing/walk_with_box.h"

namespace roomwise::live {
namespace {

using guide::KnownThing;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A home that is walked through once and again, with a red box in it that somebody moves.
class HomeViewOfWalks : public ::testing::Test {
 protected:
  using DrawnBox = pipeline::testing::DrawnBox;

  void SetUp() override {
    finders_.in_pictures.push_back(std::make_unique<pipeline::testing::RedFinder>());
    home_.emplace(pipeline::create_home(folder_ / "a.home").value());
  }
  void walk(const std::optional<DrawnBox>& box) {
    pipeline::testing::WalkWithBox source(14, 0.05, box);
    const auto summary = pipeline::map_recording(
        source, {"walk", "made up", source.info().camera, source.info().frames_remaining}, *home_,
        {}, pipeline::MapSettings{}, run_, finders_);
    ASSERT_OK(summary);
    ASSERT_TRUE(summary->is_joined);
  }
  // A visit that saw the home's things no more.
  void visit_that_misses_all(TimestampNs at_ns) {
    home::HomeChanges changes;
    changes.visit = {"visit", "made up", at_ns, at_ns, 9, 9};
    const auto things = home_->instances().value();
    for (const objects::Instance& one : things)
      changes.past.push_back({one, home::PastReason::kRemoved, 0, kStamp_ns});
    ASSERT_OK(home_->apply_changes(changes));
  }
  guide::ChangedThings latest() { return view_home(*home_, {}, nullptr).value()->latest; }
  static auto called(const std::string& name) { return Field(&KnownThing::name, name); }

  static constexpr TimestampNs kStamp_ns = 1'700'000'000'000'000'000;
  inline static const DrawnBox kBox{
      {Eigen::Vector3d(-0.2, -0.1, 0.9), Eigen::Vector3d(0.25, 0.35, 1.2)}};
  inline static const DrawnBox kElsewhere{
      {Eigen::Vector3d(0.7, -0.1, 0.8), Eigen::Vector3d(1.1, 0.35, 1.1)}};

  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  pipeline::RunContext run_{pool_, progress_, clock_};
  objects::ObjectFinders finders_;
  std::optional<home::Home> home_;
};

TEST_F(HomeViewOfWalks, TellsWhatTheNewestWalkFoundMoved) {
  walk(kBox);
  EXPECT_TRUE(latest().empty()) << "one walk alone changes nothing";
  walk(kElsewhere);
  EXPECT_THAT(latest().moved, ElementsAre(called("sofa")));
  EXPECT_THAT(latest().arrived, IsEmpty());
  EXPECT_THAT(latest().gone, IsEmpty());
}

TEST_F(HomeViewOfWalks, TellsWhatTheNewestWalkFoundGone) {
  walk(kBox);
  walk(std::nullopt);
  EXPECT_THAT(latest().moved, IsEmpty());
  EXPECT_THAT(latest().gone, ElementsAre(called("sofa")));
}

TEST_F(HomeViewOfWalks, TellsAChangeAsSomebodyCorrectedIt) {
  walk(std::nullopt);
  walk(kBox);
  EXPECT_THAT(latest().arrived, ElementsAre(called("sofa")));
  auto things = home_->instances().value();
  ASSERT_THAT(things, SizeIs(1));
  things[0].name = "armchair";
  ASSERT_OK(home_->replace_instances(things));
  EXPECT_THAT(latest().arrived, ElementsAre(called("armchair")));
  EXPECT_EQ(view_home(*home_, {}, nullptr).value()->changes->things.at(0).name, "armchair");
  ASSERT_OK(home_->replace_instances({}));
  EXPECT_TRUE(latest().empty()) << "it was taken out: it never came";
  EXPECT_FALSE(view_home(*home_, {}, nullptr).value()->changes);
}

TEST_F(HomeViewOfWalks, TellsWhatAVisitFoundGoneAndWhenItWasSeenLast) {
  walk(kBox);
  visit_that_misses_all(kStamp_ns + 86'400'000'000'000);
  const guide::ChangedThings changed = latest();
  ASSERT_THAT(changed.gone, ElementsAre(called("sofa")));
  EXPECT_EQ(changed.gone[0].seen, calendar_time(kStamp_ns));
}

TEST_F(HomeViewOfWalks, TellsWhatAVisitFoundGoneAsSomebodyCorrectedIt) {
  walk(kBox);
  const auto things = pipeline::find_home_things(*home_).value().things;
  ASSERT_OK(pipeline::rename_thing(*home_, {"Anna", 1}, things.at(0), "armchair"));
  visit_that_misses_all(kStamp_ns + 86'400'000'000'000);
  EXPECT_THAT(latest().gone, ElementsAre(called("armchair")));
}

TEST_F(HomeViewOfWalks, TellsTheWalkMappedLastWhereStampsDoNotTellTheDate) {
  walk(kBox);
  walk(kElsewhere);
  visit_that_misses_all(kStamp_ns);
  EXPECT_THAT(latest().gone, IsEmpty()) << "the made-up walks' clock tells no date";
}

TEST(HomeViewOfSpots, PutsThemOnThePlanOfTheirStorey) {
  LiveMap map;
  fusion::Storey upper;
  upper.floor_m = 2.5;
  upper.plan_from_gravity = {12, 0};
  upper.plan_from_x_m = 6;
  map.frame.storeys = fusion::Storeys({fusion::Storey{}, upper});
  HomeView view;
  view.map = std::make_shared<const LiveMap>(map);
  ViewedKeyframe& upstairs = view.keyframes.emplace_back();
  upstairs.keyframe.pose = {{Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, 0, 4)}, 0};
  pipeline::MarkedSpot spot;
  spot.place =
      pipeline::spot_place(std::array{upstairs.keyframe}, Eigen::Vector3d(1.5, 0.2, 3.5)).value();
  const ViewedSpot viewed = view_spot(spot, "my chair", view);
  ASSERT_TRUE(viewed.thing.position_plan);
  EXPECT_LT((*viewed.thing.position_plan - Eigen::Vector3d(13.5, 0.2, 1)).norm(), 1e-9);
}

}  // namespace
}  // namespace roomwise::live
