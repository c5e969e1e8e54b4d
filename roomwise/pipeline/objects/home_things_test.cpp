#include "roomwise/pipeline/objects/home_things.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/red_finder.h"
#include "roomwise/pipeline/testing/walk_with_box.h"

namespace roomwise::pipeline {
namespace {

using testing::DrawnBox;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using testing::WalkWithBox;

// A home that is walked through once and again, with a red box in it, which programs call a sofa.
class HomeThingsOfWalks : public ::testing::Test {
 protected:
  static constexpr int kFrames = 14;
  static constexpr double kStep_rad = 0.05;

  void SetUp() override {
    finders_.in_pictures.push_back(std::make_unique<testing::RedFinder>());
    home_.emplace(create_home(folder_ / "a.home").value());
  }
  void walk(const std::optional<DrawnBox>& box) {
    WalkWithBox source(kFrames, kStep_rad, box);
    ASSERT_OK(map_recording(
        source, {"walk", "made up", source.info().camera, source.info().frames_remaining}, *home_,
        {}, MapSettings{}, run_, finders_));
  }
  HomeThings things() { return find_home_things(*home_).value(); }
  HomeThing thing() { return things().things.at(0); }
  Eigen::Vector3d middle(const objects::Instance& thing) {
    return thing.box_world(home_->keyframes()->at(thing.keyframe_id).pose.world_from_keyframe)
        .center();
  }
  std::vector<std::string> names() {
    std::vector<std::string> names;
    for (const HomeThing& one : things().things) names.push_back(one.name);
    return names;
  }
  std::string digest() { return home_->content_digest().value(); }

  inline static const DrawnBox kBox{
      {Eigen::Vector3d(-0.2, -0.1, 0.9), Eigen::Vector3d(0.25, 0.35, 1.2)}};
  // A home takes no recording twice: the red is another.
  inline static const DrawnBox kBoxAgain{kBox.extent, {245, 0, 0}};
  inline static const DrawnBox kElsewhere{
      {Eigen::Vector3d(0.7, -0.1, 0.8), Eigen::Vector3d(1.1, 0.35, 1.1)}};
  inline static const std::vector<rooms::Room> kRooms{{"hall", "hall"}, {"kitchen", "kitchen"}};
  inline static const EditAuthor kAnna{"Anna's phone", 1'753'000'000};

  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
  objects::ObjectFinders finders_;
  std::optional<home::Home> home_;
};

TEST_F(HomeThingsOfWalks, AreWhatProgramsFoundWhereNobodyChangedAnything) {
  walk(kBox);
  ASSERT_THAT(things().things, SizeIs(1));
  EXPECT_EQ(thing().name, "sofa");
  EXPECT_EQ(thing().found_as, "sofa");
  EXPECT_FALSE(thing().is_confirmed);
}

TEST_F(HomeThingsOfWalks, WhatSomebodyRenamedIsCalledSoForCertain) {
  walk(kBox);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "Anna's armchair"));
  EXPECT_EQ(thing().name, "Anna's armchair");
  EXPECT_EQ(thing().probability, 1);
  EXPECT_EQ(thing().found_as, "sofa");
  EXPECT_EQ(home_->instances()->front().name, "sofa") << "what programs found is not touched";
}

TEST_F(HomeThingsOfWalks, ANameAndANoteOutliveALaterWalkThatFindsThingsAnew) {
  walk(kBox);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  ASSERT_OK(note_thing(*home_, kAnna, thing(), "the left leg is loose"));
  walk(kBoxAgain);
  ASSERT_THAT(names(), ElementsAre("armchair"));
  EXPECT_EQ(thing().note, "the left leg is loose");
  ASSERT_OK(update_objects(*home_, {}));
  EXPECT_THAT(names(), ElementsAre("armchair"));
}

TEST_F(HomeThingsOfWalks, WhoNotedOnAThingCalledItSoWhateverProgramsCallItLater) {
  walk(kBox);
  ASSERT_OK(note_thing(*home_, kAnna, thing(), "soft"));
  // As a later walk's pictures may have it: another class, and another best picture.
  auto found = home_->instances().value();
  found[0].name = "bed";
  found[0].names = {{"bed", 1.0}};
  found[0].picture_box.left += 1;
  ASSERT_OK(home_->replace_instances(found));
  ASSERT_THAT(names(), ElementsAre("sofa"));
  EXPECT_EQ(thing().note, "soft");
  EXPECT_EQ(thing().found_as, "bed");
}

TEST_F(HomeThingsOfWalks, ANameGoesWithAThingThatAWalkFindsMoved) {
  walk(kBox);
  const Eigen::Vector3d stood = middle(thing());
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  walk(kElsewhere);
  ASSERT_THAT(names(), ElementsAre("armchair"));
  EXPECT_GT((middle(thing()) - stood).norm(), 0.4);
}

TEST_F(HomeThingsOfWalks, AChangeOfWhatIsGoneIsKeptAndHoldsWhenItIsBack) {
  walk(kBox);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  walk(std::nullopt);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_EQ(things().without_effect.at(1), "the walks found it gone");
  ASSERT_THAT(find_home_history(*home_)->things, SizeIs(1));
  EXPECT_EQ(find_home_history(*home_)->things[0].thing.name, "armchair") << "history, too";
  walk(kBoxAgain);
  EXPECT_THAT(names(), ElementsAre("armchair"));
  EXPECT_THAT(things().without_effect, IsEmpty());
}

TEST_F(HomeThingsOfWalks, OfWhatWasNotThereNobodySaysThatItIsGone) {
  walk(kBox);
  ASSERT_OK(remove_thing(*home_, kAnna, thing()));
  walk(std::nullopt);
  EXPECT_THAT(find_home_history(*home_)->things, IsEmpty());
}

TEST_F(HomeThingsOfWalks, ANameGoesWithAThingThatVisitsFindMovedOrGone) {
  walk(kBox);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  const objects::Instance stood = home_->instances()->front();
  const auto visit = [&](const objects::Instance& from, std::optional<double> to_m) {
    home::HomeChanges changes;
    changes.visit = {"visit", "made up", 1, 2, 9, 9};
    changes.past.push_back(
        {from, to_m ? home::PastReason::kMoved : home::PastReason::kRemoved, 0, 1});
    if (to_m) {
      objects::Instance to = from;
      to.picture_box = {};
      to.box_keyframe.world_from_box.translation.x() += *to_m;
      changes.arrived.push_back(to);
    }
    ASSERT_OK(home_->apply_changes(changes));
  };
  visit(stood, 1.5);
  EXPECT_THAT(names(), ElementsAre("armchair"));
  visit(home_->instances()->front(), 1.5);
  EXPECT_THAT(names(), ElementsAre("armchair")) << "and on";
  const objects::Instance last = home_->instances()->front();
  visit(last, std::nullopt);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_EQ(things().name_of_gone(last), "armchair");
  EXPECT_EQ(things().without_effect.at(1), "the walks found it gone");
}

TEST_F(HomeThingsOfWalks, OfTwoAlikeThatAVisitFindsMovedEachKeepsItsName) {
  walk(kBox);
  const auto at = [](objects::Instance one, double x_m) {
    one.picture_box = {};
    one.box_keyframe.world_from_box.translation.x() += x_m;
    return one;
  };
  objects::Instance one = home_->instances()->front();
  const objects::Instance other = at(one, 3);
  ASSERT_OK(home_->replace_instances(std::vector{one, other}));
  ASSERT_OK(rename_thing(*home_, kAnna, things().things[0], "Anna's"));
  ASSERT_OK(rename_thing(*home_, kAnna, things().things[1], "Tom's"));
  home::HomeChanges changes;
  changes.visit = {"visit", "made up", 1, 2, 9, 9};
  changes.past = {{one, home::PastReason::kMoved, 0, 1}, {other, home::PastReason::kMoved, 0, 1}};
  changes.arrived = {at(one, 6), at(other, 1), at(one, 0.8)};  // and a new one far off
  ASSERT_OK(home_->apply_changes(changes));
  EXPECT_THAT(names(), ElementsAre("sofa", "Tom's", "Anna's"));
}

TEST_F(HomeThingsOfWalks, WhatIsNotThereStaysAwayWhenAWalkSeesItAgain) {
  walk(kBox);
  ASSERT_OK(remove_thing(*home_, kAnna, thing()));
  EXPECT_THAT(names(), IsEmpty());
  walk(kBoxAgain);
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_THAT(*home_->instances(), SizeIs(1)) << "programs find it all the same";
  EXPECT_THAT(find_home_history(*home_)->things, IsEmpty()) << "nor does history tell of it";
}

TEST_F(HomeThingsOfWalks, ChangesMoveWithTheMap) {
  walk(kBox);
  const Eigen::Vector3d there = middle(thing()) + Eigen::Vector3d(0.8, 0, 0);
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {there, ""}));
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  std::map<home::KeyframeId, home::KeyframePose> poses;
  const geometry::RigidTransform moved{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
      Eigen::Vector3d(2, 0, 1)};
  const auto all = home_->keyframes().value();
  for (const home::Keyframe& one : all) {
    poses[one.id] = {moved * one.pose.world_from_keyframe, one.pose.component};
  }
  ASSERT_OK(home_->replace_poses(poses));
  ASSERT_OK(update_objects(*home_, {}));
  ASSERT_THAT(names(), ElementsAre("armchair", "kettle"));
  EXPECT_LT((middle(things().things[1]) - moved * there).norm(), 1e-9);
}

TEST_F(HomeThingsOfWalks, AChangeOutlivesTheWalkThatItWasMadeOn) {
  walk(kBox);
  walk(kBoxAgain);
  const auto found = thing();
  ASSERT_OK(rename_thing(*home_, kAnna, found, "armchair"));
  const Eigen::Vector3d there = middle(found) + Eigen::Vector3d(0.8, 0, 0);
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {there, ""}));
  const home::RecordingId shows_it = home_->keyframes()->at(found.keyframe_id).recording;
  ASSERT_OK(forget_walk(*home_, shows_it));
  EXPECT_THAT(names(), ElementsAre("armchair", "kettle"));
}

TEST_F(HomeThingsOfWalks, AChangeWithoutAWalkIsKeptAndItIsSaid) {
  walk(kBox);
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d::Zero(), ""}));
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  ASSERT_OK(forget_walk(*home_, home_->recordings()->front().id));
  EXPECT_THAT(names(), IsEmpty());
  EXPECT_THAT(things().without_effect, SizeIs(2));
  EXPECT_THAT(*home_->edits(), SizeIs(2));
  walk(kBox);
  EXPECT_THAT(names(), ElementsAre("sofa")) << "nobody knows where it was";
}

TEST_F(HomeThingsOfWalks, WhatSomebodyAddedIsCertainAndHasItsNote) {
  walk(std::nullopt);
  ASSERT_OK(home_->replace_rooms(kRooms));
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d(0.5, 0.1, 1), "kitchen"}, "hot"));
  ASSERT_THAT(names(), ElementsAre("kettle"));
  EXPECT_EQ(thing().probability, 1);
  EXPECT_EQ(thing().note, "hot");
  EXPECT_EQ(thing().room, "kitchen");
  EXPECT_EQ(thing().added_by_edit, 1);
  EXPECT_LT((middle(thing()) - Eigen::Vector3d(0.5, 0.1, 1)).norm(), 1e-9);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "pot"));
  EXPECT_THAT(names(), ElementsAre("pot"));
  ASSERT_OK(remove_thing(*home_, kAnna, thing()));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(HomeThingsOfWalks, AThingStandsInTheRoomThatItWasPutInWhateverThatIsCalledNow) {
  walk(kBox);
  ASSERT_OK(home_->replace_rooms(kRooms));
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d(2, 0.1, 1), "kitchen"}));
  ASSERT_OK(move_thing(*home_, kAnna, thing(), {middle(thing()), "kitchen"}));
  const auto stand_in = [&] {
    std::set<std::string> rooms;
    for (const HomeThing& one : things().things) rooms.insert(one.room.value_or("no room"));
    return rooms;
  };
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  EXPECT_THAT(stand_in(), ElementsAre("galley"));
  ASSERT_OK(join_rooms(*home_, kAnna, "hall", "galley"));
  EXPECT_THAT(stand_in(), ElementsAre("hall"));
  ASSERT_OK(remove_room(*home_, kAnna, "hall"));
  EXPECT_THAT(stand_in(), ElementsAre("no room"));
  ASSERT_OK(undo_edit(*home_, home_->edits()->back().id));
  EXPECT_THAT(stand_in(), ElementsAre("hall"));
}

TEST_F(HomeThingsOfWalks, WhatSomebodyAddedIsOneWithWhatALaterWalkFindsThere) {
  walk(kBox);
  const Eigen::Vector3d there = middle(thing());
  ASSERT_OK(forget_walk(*home_, home_->recordings()->front().id));
  walk(std::nullopt);
  ASSERT_OK(add_thing(*home_, kAnna, "sofa", {there, ""}, "new cover"));
  ASSERT_THAT(names(), ElementsAre("sofa"));
  walk(kBox);
  ASSERT_THAT(names(), ElementsAre("sofa")) << "not twice";
  EXPECT_EQ(thing().note, "new cover");
  EXPECT_EQ(thing().added_by_edit, 0) << "a picture shows it now";
}

TEST_F(HomeThingsOfWalks, WhatSomebodyTookOutAndAddsAgainIsThereAgain) {
  walk(kBox);
  const Eigen::Vector3d there = middle(thing());
  ASSERT_OK(note_thing(*home_, kAnna, thing(), "soft"));
  ASSERT_OK(remove_thing(*home_, kAnna, thing()));
  ASSERT_OK(add_thing(*home_, kAnna, "sofa", {there, ""}));
  ASSERT_THAT(names(), ElementsAre("sofa"));
  EXPECT_TRUE(thing().is_confirmed);
  EXPECT_EQ(thing().note, "soft") << "who adds without a note takes none away";
}

TEST_F(HomeThingsOfWalks, WhatSomebodyMovedStaysThereAndIsOneWithWhatALaterWalkFindsThere) {
  walk(kElsewhere);
  const Eigen::Vector3d elsewhere = middle(thing());
  ASSERT_OK(forget_walk(*home_, home_->recordings()->front().id));
  walk(kBox);
  const Eigen::Vector3d target = middle(thing()) + Eigen::Vector3d(0, 0, 1.5);
  ASSERT_OK(home_->replace_rooms(kRooms));
  ASSERT_OK(move_thing(*home_, kAnna, thing(), {target, "hall"}));
  EXPECT_LT((middle(thing()) - target).norm(), 1e-9);
  EXPECT_EQ(thing().room, "hall");
  ASSERT_OK(undo_edit(*home_, 1));
  ASSERT_OK(move_thing(*home_, kAnna, thing(), {elsewhere, ""}));
  walk(kElsewhere);
  ASSERT_THAT(names(), ElementsAre("sofa"));
  EXPECT_LT((middle(thing()) - elsewhere).norm(), 0.1);
}

TEST_F(HomeThingsOfWalks, AThingAndItsDoubleAreOneAndKeepTheNote) {
  walk(kBox);
  ASSERT_OK(
      add_thing(*home_, kAnna, "couch", {middle(thing()) + Eigen::Vector3d(1, 0, 0), ""}, "soft"));
  const auto both = things().things;
  ASSERT_THAT(both, SizeIs(2));
  ASSERT_OK(merge_things(*home_, kAnna, both[0], both[1]));
  ASSERT_THAT(names(), ElementsAre("sofa"));
  EXPECT_EQ(thing().note, "soft");
  walk(kBoxAgain);
  EXPECT_THAT(names(), ElementsAre("sofa"));
}

TEST_F(HomeThingsOfWalks, UndoRestoresTheHomeToTheBit) {
  walk(kBox);
  const Eigen::Vector3d there(0.5, 0.1, 1);
  using Change = std::function<Expected<home::EditId>()>;
  const std::vector<Change> changes{
      [&] { return rename_thing(*home_, kAnna, thing(), "armchair"); },
      [&] { return note_thing(*home_, kAnna, thing(), "soft"); },
      [&] {
        return move_thing(*home_, kAnna, thing(), {there, ""});
      },
      [&] {
        return add_thing(*home_, kAnna, "kettle", {there, ""});
      },
      [&] { return merge_things(*home_, kAnna, things().things[0], things().things[1]); },
      [&] { return remove_thing(*home_, kAnna, thing()); }};
  std::vector<std::string> digests{digest()};
  for (const Change& change : changes) {
    ASSERT_OK(change());
    digests.push_back(digest());
  }
  for (std::size_t i = changes.size(); i-- > 0;) {
    ASSERT_OK(undo_edit(*home_, static_cast<home::EditId>(i + 1)));
    EXPECT_EQ(digest(), digests[i]);
  }
}

TEST_F(HomeThingsOfWalks, WhatALaterChangeIsAboutIsNotUndoneBeforeIt) {
  walk(kBox);
  ASSERT_OK(rename_thing(*home_, kAnna, thing(), "armchair"));
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d(0.9, 0.1, 1), ""}));
  ASSERT_OK(note_thing(*home_, {"Ben's phone", 1'753'000'009}, thing(), "soft"));
  EXPECT_ERROR(undo_edit(*home_, 1), "undo that first: noted on armchair: soft (change 3)");
  EXPECT_OK(undo_edit(*home_, 2)) << "the kettle is another thing";
  EXPECT_OK(undo_edit(*home_, 3));
  EXPECT_OK(undo_edit(*home_, 1));
  EXPECT_ERROR(undo_edit(*home_, 1), "no change 1");
}

TEST_F(HomeThingsOfWalks, WhoChangesWhatAnotherChangedMeanwhileIsTold) {
  walk(kBox);
  const HomeThing seen = thing();
  ASSERT_OK(rename_thing(*home_, kAnna, seen, "armchair"));
  EXPECT_ERROR(rename_thing(*home_, {"Ben's phone", 2}, seen, "divan"),
               "no such sofa any more; look at it anew");
  EXPECT_THAT(names(), ElementsAre("armchair"));
}

TEST_F(HomeThingsOfWalks, WhatCannotBeSpokenOrChangesNothingIsRefused) {
  walk(kBox);
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), "  "), "name is empty");
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), std::string(61, 'x')), "at most 60");
  EXPECT_OK(validate_spoken_name("\u00e9\u00e9\u00e9")) << "letters are counted, not bytes";
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), "so\nfa"), "line break");
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), "so\xff"), "not UTF-8");
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), "\u202eafos"), "cannot be spoken");
  EXPECT_ERROR(rename_thing(*home_, kAnna, thing(), "…"), "no letter and no digit");
  EXPECT_ERROR(note_thing(*home_, kAnna, thing(), std::string(201, 'x')), "at most 200");
  EXPECT_ERROR(note_thing(*home_, kAnna, thing(), ""), "no note to take away");
  EXPECT_ERROR(merge_things(*home_, kAnna, thing(), thing()), "its own double");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d(0, nan, 0), ""}), "finite");
  EXPECT_THAT(*home_->edits(), IsEmpty());
}

TEST_F(HomeThingsOfWalks, AHomeWithoutAMapHasNoPlaceForAThing) {
  EXPECT_ERROR(add_thing(*home_, kAnna, "kettle", {Eigen::Vector3d::Zero(), ""}), "map is empty");
}

}  // namespace
}  // namespace roomwise::pipeline
