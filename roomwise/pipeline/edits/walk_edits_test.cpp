#include "roomwise/pipeline/edits/walk_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/exports/dataset_pictures.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/map_settings.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const EditAuthor kBen{"Ben's phone", 1'760'000'000};

// A home of two walks with a key-frame each.
class WalkEdits : public ::testing::Test {
 protected:
  void SetUp() override {
    home_.emplace(create_home(folder_ / "a.home").value());
    for (const std::string name : {"monday", "sunday"}) {
      geometry::PinholeCamera camera;
      camera.width = 8;
      camera.height = 6;
      camera.fx = camera.fy = 5;
      const auto walk = home_->add_recording({name, "", camera, 10}).value();
      home::MapCommit step{
          .recording = walk, .keyframes = {}, .edges = {}, .frames = {}, .next_frame_index = 10};
      home::NewKeyframe& keyframe = step.keyframes.emplace_back();
      keyframe.id = home_->next_keyframe_id().value();
      keyframe.images = {{1}, {1}};
      ASSERT_OK(home_->commit(step));
      ASSERT_OK(home_->finish_recording(walk));
    }
  }
  std::vector<std::string> walks() {
    std::vector<std::string> names;
    const auto recordings = home_->recordings().value();
    for (const auto& one : recordings) names.push_back(one.recording.name);
    return names;
  }
  std::set<home::RecordingId> taken() { return walks_taken_away(stored_edits(*home_).value()); }

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
};

TEST_F(WalkEdits, AWalkThatIsTakenAwayStaysUntilItIsForgottenAndCanComeBack) {
  const std::string digest = home_->content_digest().value();
  const home::EditId edit = take_walk_away(*home_, kBen, 2).value();
  EXPECT_THAT(taken(), ElementsAre(2));
  EXPECT_THAT(walks(), ElementsAre("monday", "sunday"));
  EXPECT_EQ(describe(stored_edits(*home_)->front()), "took the walk sunday away");
  EXPECT_ERROR(take_walk_away(*home_, kBen, 2), "'sunday' is taken away already");
  EXPECT_ERROR(take_walk_away(*home_, kBen, 7), "has no walk 7");
  ASSERT_OK(undo_edit(*home_, edit));
  EXPECT_THAT(taken(), IsEmpty());
  EXPECT_EQ(home_->content_digest().value(), digest);
}

TEST_F(WalkEdits, NothingOfAWalkThatIsTakenAwayIsWrittenForOthers) {
  EXPECT_THAT(dataset_views(*home_, {})->views, SizeIs(2));
  const home::EditId edit = take_walk_away(*home_, kBen, 2).value();
  const auto written = dataset_views(*home_, {});
  ASSERT_OK(written);
  ASSERT_THAT(written->walks, SizeIs(1));
  EXPECT_EQ(written->walks.front().name, "monday");
  EXPECT_THAT(written->views, SizeIs(1));
  EXPECT_ERROR(dataset_views(*home_, {.walk = 2}), "no key-frame of that walk");
  EXPECT_THAT(walks_that_stay(*home_).value(), SizeIs(1));
  ASSERT_OK(undo_edit(*home_, edit));
  EXPECT_THAT(dataset_views(*home_, {})->views, SizeIs(2));
}

TEST_F(WalkEdits, ForgettingTakesTheWalksAndTheChangesThatTookThemAway) {
  ASSERT_OK(take_walk_away(*home_, kBen, 1));
  EXPECT_FALSE(home_->owes_erasing().value());
  const auto forgotten = forget_taken_walks(*home_).value();
  ASSERT_THAT(forgotten, SizeIs(1));
  EXPECT_EQ(forgotten.front().recording.name, "monday");
  EXPECT_THAT(walks(), ElementsAre("sunday"));
  EXPECT_THAT(stored_edits(*home_).value(), IsEmpty());
  EXPECT_TRUE(home_->owes_erasing().value());
}

TEST_F(WalkEdits, OnlyTheFolderInTheHomesOwnIsRemovedWithAWalk) {
  namespace fs = std::filesystem;
  const fs::path own = folder_ / "a.home.walks";
  const auto make = [](const fs::path& folder) {
    fs::create_directories(folder);
    return folder.string();
  };
  const auto remove = [&](const std::string& folder) {
    home::StoredRecording walk;
    walk.recording.folder = folder;
    return remove_walk_folder(*home_, walk);
  };
  make(own / "first");
  make(own / "second");
  make(own / "third");
  make(own / "fourth");
  const std::string elsewhere = make(folder_ / "recordings" / "fourth");
  const std::string of_original = make(folder_ / "original.home.walks" / "third");
  ASSERT_OK(remove((own / "first").string()));
  EXPECT_FALSE(fs::exists(own / "first"));
  ASSERT_OK(remove("a.home.walks/second")) << "as of a home that was served by a relative name";
  EXPECT_FALSE(fs::exists(own / "second"));
  ASSERT_OK(remove(of_original)) << "as of a home that was copied from another";
  EXPECT_FALSE(fs::exists(own / "third"));
  EXPECT_TRUE(fs::exists(of_original));
  for (const std::string& other :
       {elsewhere, own.string(), own.string() + "/", std::string(), std::string("fourth"),
        std::string("a.home.walks/.."), std::string("a.home.walks/.")}) {
    ASSERT_OK(remove(other));
    EXPECT_TRUE(fs::exists(own / "fourth")) << other;
  }
  EXPECT_TRUE(fs::exists(elsewhere));
  ASSERT_OK(remove((own / "nothing").string()));
}

TEST_F(WalkEdits, AWalkOfAnotherHomeIsNotTheHomesOwnOfThatName) {
  namespace fs = std::filesystem;
  const fs::path own = folder_ / "a.home.walks", others = folder_ / "b.home.walks";
  fs::create_directories(others / "walk");
  home::StoredRecording other;
  other.recording.folder = (others / "walk").string();
  EXPECT_EQ(folder_of_walk(*home_, other), others / "walk") << "there is none of that name";
  fs::create_directories(own / "walk");
  const geometry::PinholeCamera camera = home_->recordings()->front().recording.camera;
  ASSERT_OK(home_->add_recording({"walk", (own / "walk").string(), camera, 10}));
  EXPECT_EQ(folder_of_walk(*home_, other), others / "walk");
  ASSERT_OK(remove_walk_folder(*home_, other));
  EXPECT_TRUE(fs::exists(own / "walk"));
  EXPECT_TRUE(fs::exists(others / "walk"));
}

TEST_F(WalkEdits, ChangesOfRoomsAndWalksAreUndoneInAnyOrder) {
  const auto labels = recording::RoomLabels::from_ranges({{0, 9, "kitchen", 1}}).value();
  ASSERT_OK(name_frames(*home_, kBen, 1, labels));
  const home::EditId renamed = rename_room(*home_, kBen, "kitchen", "cookery").value();
  const home::EditId took = take_walk_away(*home_, kBen, 2).value();
  ASSERT_OK(undo_edit(*home_, renamed)) << "the walk is another matter";
  ASSERT_OK(set_room_type(*home_, kBen, "kitchen", "workshop"));
  ASSERT_OK(undo_edit(*home_, took));
  EXPECT_THAT(taken(), IsEmpty());
}

TEST_F(WalkEdits, AWalkThatIsTakenAwayOutlivesForgettingARoom) {
  const auto labels = recording::RoomLabels::from_ranges({{0, 9, "kitchen", 1}}).value();
  ASSERT_OK(name_frames(*home_, kBen, 1, labels));
  ASSERT_OK(take_walk_away(*home_, kBen, 2));
  ASSERT_OK(remove_room(*home_, kBen, "kitchen"));
  ASSERT_OK(forget_removed_rooms(*home_));
  EXPECT_THAT(taken(), ElementsAre(2));
}

}  // namespace
}  // namespace roomwise::pipeline
