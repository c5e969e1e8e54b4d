#include "roomwise/pipeline/objects/thing_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/home/testing/sample_home.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/red_finder.h"
#include "roomwise/pipeline/testing/walk_with_box.h"

namespace roomwise::pipeline {
namespace {

using testing::DrawnBox;
using ::testing::ElementsAre;
using testing::WalkWithBox;

// A walk whose depth camera measures nothing where a box of this colour stands.
class WalkWithGap final : public recording::FrameSource {
 public:
  static constexpr Rgb8 kColor{90, 91, 92};
  WalkWithGap(int frames, double step_rad, DrawnBox box) : walk_(frames, step_rad, painted(box)) {}
  [[nodiscard]] const recording::SourceInfo& info() const override { return walk_.info(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    ROOMWISE_TRY(auto frame, walk_.next());
    for (int y = 0; frame && y < frame->color.height(); ++y) {
      for (int x = 0; x < frame->color.width(); ++x) {
        if (frame->color.at(x, y) == kColor) frame->depth.at(x, y) = 0;
      }
    }
    return frame;
  }

 private:
  static DrawnBox painted(DrawnBox box) {
    box.color = kColor;
    return box;
  }
  WalkWithBox walk_;
};

// A home that is walked through once and again, with a red box in it that somebody moves.
class ThingHistories : public ::testing::Test {
 protected:
  static constexpr int kFrames = 14;
  static constexpr double kStep_rad = 0.05;

  void SetUp() override {
    finders_.in_pictures.push_back(std::make_unique<testing::RedFinder>());
    home_.emplace(create_home(folder_ / "a.home").value());
  }
  void walk(const std::optional<DrawnBox>& box, TimestampNs begins_ns = 1'000'000'000) {
    WalkWithBox source(kFrames, kStep_rad, box);
    source.begin_at(begins_ns);
    map(source);
  }
  void map(recording::FrameSource& source) {
    const auto summary = map_recording(
        source, {"walk", "made up", source.info().camera, source.info().frames_remaining}, *home_,
        {}, MapSettings{}, run_, finders_);
    ASSERT_OK(summary);
    ASSERT_TRUE(summary->is_joined);
  }
  HomeHistory history() { return find_home_history(*home_).value(); }
  static std::vector<std::string> words(const ThingHistory& thing) {
    std::vector<std::string> words;
    for (const WalkEvent& event : thing.events) words.emplace_back(to_string(event.what));
    return words;
  }
  Eigen::Vector3d middle(const objects::Instance& thing) {
    return thing.box_world(home_->keyframes()->at(thing.keyframe_id).pose.world_from_keyframe)
        .center();
  }

  inline static const DrawnBox kBox{
      {Eigen::Vector3d(-0.2, -0.1, 0.9), Eigen::Vector3d(0.25, 0.35, 1.2)}};
  // A home takes no recording twice: the red is another.
  inline static const DrawnBox kBoxAgain{kBox.extent, {245, 0, 0}};
  inline static const DrawnBox kElsewhere{
      {Eigen::Vector3d(0.7, -0.1, 0.8), Eigen::Vector3d(1.1, 0.35, 1.1)}};

  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
  objects::ObjectFinders finders_;
  std::optional<home::Home> home_;
};

TEST_F(ThingHistories, WhatStandsStillIsOneThingOfAllWalks) {
  walk(kBox);
  walk(kBoxAgain);
  const HomeHistory told = history();
  ASSERT_EQ(told.things.size(), 1U);
  EXPECT_THAT(words(told.things[0]), ElementsAre("found", "there"));
  EXPECT_EQ(told.things[0].first_seen.walk, told.walks[0]);
  EXPECT_EQ(told.things[0].last_seen.walk, told.walks[1]);
  ASSERT_EQ(home_->instances()->size(), 1U);
  EXPECT_EQ(told.of(home_->instances()->front()), &told.things[0]);
}

TEST_F(ThingHistories, WhatMovedIsListedOnceWhereItStandsNow) {
  walk(kBox);
  const Eigen::Vector3d stood = middle(home_->instances()->front());
  walk(kElsewhere);
  const HomeHistory told = history();
  ASSERT_EQ(told.things.size(), 1U);
  EXPECT_THAT(words(told.things[0]), ElementsAre("found", "moved"));
  ASSERT_TRUE(told.things[0].events[1].from);
  EXPECT_LT((middle(*told.things[0].events[1].from) - stood).norm(), 0.05);
  const auto instances = home_->instances();
  ASSERT_EQ(instances->size(), 1U);
  EXPECT_GT((middle(instances->front()) - stood).norm(), 0.4);
}

TEST_F(ThingHistories, WhatIsGoneIsListedNoMoreAndMayComeBack) {
  walk(kBox);
  walk(std::nullopt);
  HomeHistory told = history();
  ASSERT_EQ(told.things.size(), 1U);
  EXPECT_TRUE(told.things[0].is_gone);
  EXPECT_THAT(words(told.things[0]), ElementsAre("found", "gone"));
  EXPECT_EQ(told.things[0].last_seen.walk, told.walks[0]);
  EXPECT_TRUE(home_->instances()->empty());

  walk(kBoxAgain);
  told = history();
  ASSERT_EQ(told.things.size(), 2U) << "nobody can say that it is the same one";
  EXPECT_THAT(words(told.things[0]), ElementsAre("new"));
  EXPECT_TRUE(told.things[1].is_gone);
  EXPECT_EQ(home_->instances()->size(), 1U);
}

TEST_F(ThingHistories, WhatAVisitFoundGoneIsThereOnceAWalkAfterItSawIt) {
  constexpr TimestampNs kDay_ns = 86'400'000'000'000;
  constexpr TimestampNs kMonday_ns = 1'760'000'000'000'000'000;
  constexpr TimestampNs kVisit_ns = kMonday_ns + 2 * kDay_ns;
  for (const int day : {1, 3}) {
    home_.emplace(create_home(folder_ / fmt::format("{}.home", day)).value());
    walk(kBox, kMonday_ns);
    home::HomeChanges gone;
    gone.visit = {"visit", "", kVisit_ns, kVisit_ns, 1, 1};
    gone.past.push_back({.instance = home_->instances()->front()});
    ASSERT_OK(home_->apply_changes(gone));
    EXPECT_TRUE(home_->instances()->empty());
    walk(kBoxAgain, kMonday_ns + day * kDay_ns);
    EXPECT_EQ(home_->instances()->size(), day == 3 ? 1U : 0U) << day;
  }
}

TEST_F(ThingHistories, WhatAWalkDidNotLookAtStaysAndItIsSaid) {
  walk(kBox);
  WalkWithGap dark(kFrames, kStep_rad, kBox);
  map(dark);
  const HomeHistory told = history();
  ASSERT_EQ(told.things.size(), 1U);
  EXPECT_FALSE(told.things[0].is_gone);
  EXPECT_THAT(words(told.things[0]), ElementsAre("found", "not looked at"));
  EXPECT_EQ(told.things[0].last_seen.walk, told.walks[0]);
}

TEST_F(ThingHistories, AreTheSameWhetherTheHomeKeepsThemOrNot) {
  walk(kBox);
  walk(kElsewhere);
  const HomeHistory kept = history();
  const HomeHistory anew = follow_things(*home_).value();
  ASSERT_EQ(kept.things.size(), anew.things.size());
  EXPECT_EQ(kept.walks, anew.walks);
  EXPECT_EQ(words(kept.things[0]), words(anew.things[0]));
  EXPECT_EQ(kept.things[0].last_seen, anew.things[0].last_seen);
  EXPECT_EQ(kept.things[0].thing.name, anew.things[0].thing.name);
}

TEST_F(ThingHistories, GoWithAWalkThatIsForgotten) {
  walk(kBox);
  walk(std::nullopt);
  ASSERT_TRUE(home_->instances()->empty());
  ASSERT_OK(forget_walk(*home_, home_->recordings()->back().id));
  const HomeHistory told = history();
  ASSERT_EQ(told.things.size(), 1U);
  EXPECT_FALSE(told.things[0].is_gone);
  EXPECT_EQ(home_->instances()->size(), 1U);
}

TEST_F(ThingHistories, ThatAreDamagedAreFollowedAnew) {
  using nlohmann::json;
  walk(kBox);
  walk(kElsewhere);
  const home::DerivedData whole = home_->derived_data("things").value().value();
  const HomeHistory anew = follow_things(*home_).value();
  const auto is_told_from = [&](const Bytes& data) {
    ROOMWISE_MUST(home_->put_derived_data({whole.name, whole.made_from, data}));
    const auto told = find_home_history(*home_);
    ASSERT_OK(told);
    ASSERT_EQ(told->things.size(), 1U);
    EXPECT_EQ(told->things[0].thing.name, "sofa");
    EXPECT_EQ(told->things[0].thing.keyframe_id, anew.things[0].thing.keyframe_id);
    EXPECT_EQ(told->things[0].last_seen, anew.things[0].last_seen);
    EXPECT_EQ(told->walks, anew.walks);
    EXPECT_THAT(words(told->things[0]), ElementsAre("found", "moved"));
  };
  for (const std::size_t size : {std::size_t{0}, std::size_t{9}, whole.data.size() - 1}) {
    is_told_from(Bytes(whole.data.begin(), whole.data.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<const char*, json>> damages{
      {"/walks", json::array()},
      {"/walks/0", 99},
      {"/things/0/events", json::array()},
      {"/things/0/events/1/walk", 99},
      {"/things/0/events/1/what", "stolen"},
      {"/things/0/events/1/from/keyframe", 1'000'000'000},
      {"/things/0/last_seen/walk", 99},
      {"/things/0/last_seen/time_ns", 1e300},
      {"/things/0/thing/keyframe", 1'000'000'000},
      {"/things/0/thing/keyframe", -1},
      {"/things/0/thing/probability", nan},
      {"/things/0/thing/box/3", nan},
      {"/things/0/thing/box/9", std::numeric_limits<double>::infinity()},
      {"/things/0/thing/picture_box/0", 1e300},
  };
  for (const auto& [place, value] : damages) {
    SCOPED_TRACE(place);
    json damaged = json::from_cbor(whole.data);
    ASSERT_TRUE(damaged.contains(json::json_pointer(place)));
    damaged[json::json_pointer(place)] = value;
    is_told_from(json::to_cbor(damaged));
  }
}

TEST_F(ThingHistories, FollowWhatSomebodyCorrects) {
  walk(std::nullopt);
  walk(kBox);
  const auto instances = home_->instances().value();
  ASSERT_EQ(instances.size(), 1U);
  StoredEdit rename{.kind = EditKind::kRenameThing,
                    .change = {.name = "armchair"},
                    .places = {place_of(instances[0])}};
  ASSERT_OK(home_->add_edit(rename.row()));
  const HomeHistory renamed = history();
  const auto changes = renamed.changes_by(renamed.walks.back());
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].thing->thing.name, "armchair");
  EXPECT_EQ(changes[0].event->what, ThingEvent::kNew);
  EXPECT_TRUE(renamed.changes_by(renamed.walks.front()).empty());
  ASSERT_OK(home_->replace_instances({}));
  EXPECT_TRUE(history().things.empty()) << "it was taken out: it never was there";
}

TEST_F(ThingHistories, AreKeptAnewOnceTheMapHasMoved) {
  const auto made_from = [&] { return home_->derived_data("things").value().value().made_from; };
  walk(kBox);
  const std::string before = made_from();
  ASSERT_OK(keep_home_history(*home_));
  EXPECT_EQ(made_from(), before) << "mapping a walk keeps them";
  auto pose = home_->keyframes()->at(3).pose;
  pose.world_from_keyframe.translation.x() += 0.001;
  ASSERT_OK(home_->replace_poses({{3, pose}}));
  ASSERT_OK(find_home_history(*home_));
  EXPECT_EQ(made_from(), before) << "who only reads keeps nothing";
  ASSERT_OK(keep_home_history(*home_));
  EXPECT_NE(made_from(), before);
}

}  // namespace
}  // namespace roomwise::pipeline
