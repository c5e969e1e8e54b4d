#include "roomwise/pipeline/edits/edit_rooms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/testing/sample_home.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/rooms/learning/room_learner.h"

namespace roomwise::pipeline {
namespace {

using Eigen::Vector2d;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A home of one floor of 6 m by 2 m, walked along its middle from left to right: the first half was
// named kitchen, the second bedroom. The map's world is the gravity-aligned frame.
class RoomEdits : public ::testing::Test {
 protected:
  static constexpr std::size_t kFrames = 60;

  void SetUp() override {
    home_.emplace(create_home(folder_ / "a.home").value());
    add_walk("monday");
    image::Image<fusion::FloorCell> cells(60, 20, fusion::FloorCell::kFree);
    floor_.grid = fusion::FloorGrid(Vector2d::Zero(), 0.1, std::move(cells));
    ASSERT_OK(name_frames(*home_, kAnna, 1, labels({{0, 29, "kitchen"}, {30, 59, "bedroom"}})));
    ASSERT_THAT(names(), ElementsAre("bedroom", "kitchen"));
  }

  home::RecordingId add_walk(const std::string& name) {
    geometry::PinholeCamera camera;
    camera.width = 8;
    camera.height = 6;
    camera.fx = camera.fy = 5;
    const auto walk = home_->add_recording({name, "", camera, kFrames}).value();
    home::MapCommit step{
        .recording = walk, .keyframes = {}, .edges = {}, .frames = {}, .next_frame_index = kFrames};
    const home::KeyframeId first = home_->next_keyframe_id().value();
    for (std::size_t i = 0; i < kFrames; ++i) {
      const auto time_ns = static_cast<TimestampNs>(i);
      home::NewKeyframe& keyframe = step.keyframes.emplace_back();
      keyframe.id = first + i;
      keyframe.frame_index = i;
      keyframe.timestamp_ns = time_ns;
      keyframe.images = {{1}, {1}};
      keyframe.pose.world_from_keyframe.translation = {0.05 + 0.1 * static_cast<double>(i), 1, 1.2};
      step.frames.push_back({i, time_ns, home::FramePlace{first + i, {}}, ""});
    }
    EXPECT_OK(home_->commit(step));
    return walk;
  }
  static recording::RoomLabels labels(std::vector<recording::RoomRange> ranges) {
    std::map<std::string, int> stays;
    for (recording::RoomRange& range : ranges) range.stay = ++stays[range.room];
    return recording::RoomLabels::from_ranges(std::move(ranges)).value();
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    const auto all = home_->rooms().value();
    for (const rooms::Room& room : all) names.push_back(room.name);
    return names;
  }
  [[nodiscard]] std::string type_of(const std::string& name) const {
    const auto all = home_->rooms().value();
    for (const rooms::Room& room : all) {
      if (room.name == name) return room.type;
    }
    return "no such room";
  }
  [[nodiscard]] std::string room_of_frame(std::uint64_t frame, home::RecordingId walk = 1) const {
    const auto named = home_->room_ranges(walk).value();
    const auto* const range = named.find(frame);
    return range != nullptr ? range->room : "";
  }
  [[nodiscard]] std::string room_at(double x, double y = 1) const {
    const auto layout = find_room_layout(*home_, floor_.frame, *floor_.grid).value().value();
    return layout.room_at({x, y}).value_or("");
  }
  [[nodiscard]] std::string digest() const { return home_->content_digest().value(); }
  // Rooms learned from made-up numbers.
  void learn(const std::string& network, const std::string& other,
             const std::string& report = "{}") {
    std::vector<rooms::RoomSample> samples;
    for (std::uint64_t i = 0; i < 40; ++i) {
      const float small = 0.1F * static_cast<float>(i % 5);
      samples.push_back({{9, small, 1}, "kitchen", 1, i / 10});
      samples.push_back({{small, 9, 1}, other, 1, i / 10});
    }
    const auto learned = rooms::learn_rooms(samples, {network, network});
    ASSERT_OK(learned);
    ASSERT_OK(
        home_->put_room_classifier({network, network, learned->classifier.to_bytes(), report}));
  }
  // The newest change taken back.
  void undo() { ASSERT_OK(undo_edit(*home_, home_->edits()->back().id)); }

  static FloorLine upwards(double x) { return {{x, 0}, {x, 2}}; }
  inline static const EditAuthor kAnna{"Anna's phone", 1'753'000'000};

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
  HomeFloor floor_;
};

TEST_F(RoomEdits, ARoomThatIsRenamedKeepsItsTypeWhateverItIs) {
  ASSERT_OK(set_room_type(*home_, kAnna, "kitchen", "scullery"));
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "Anna's realm"));
  EXPECT_THAT(names(), ElementsAre("Anna's realm", "bedroom"));
  EXPECT_EQ(type_of("Anna's realm"), "scullery");
  EXPECT_EQ(room_of_frame(3), "Anna's realm");
  EXPECT_EQ(room_at(1), "Anna's realm");
}

TEST_F(RoomEdits, AThingThatSomebodyTaughtWasSeenInTheRoomAsItIsCalledNow) {
  const home::OwnThingId mug =
      home_
          ->add_own_thing({.name = "my mug", .owner = "7"},
                          std::vector<objects::TaughtView>{{Bytes(9, 1), Bytes(9, 1)}})
          .value();
  ASSERT_OK(home_->put_own_thing_sighting(mug, {1'753'000'000, "kitchen", {}, {}}));
  const auto seen = [&] { return home_->own_things()->at(0).last_seen; };
  ASSERT_OK(rename_room(*home_, kAnna, "bedroom", "den"));
  EXPECT_EQ(seen().room, "kitchen") << "another room";
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  EXPECT_EQ(seen().room, "galley");
  EXPECT_EQ(seen().seen_s, 1'753'000'000) << "it was seen when it was";
  undo();
  EXPECT_EQ(seen().room, "kitchen");
  ASSERT_OK(join_rooms(*home_, kAnna, "den", "kitchen"));
  EXPECT_EQ(seen().room, "den");
}

TEST_F(RoomEdits, ARoomRenamedByNamingItsFramesAnewIsTheSameRoom) {
  ASSERT_OK(set_room_type(*home_, kAnna, "kitchen", "scullery"));
  ASSERT_OK(store_object_claims(*home_, {{"kettle", "kitchen", true}}));
  ASSERT_OK(name_frames(*home_, kAnna, 1, labels({{0, 29, "galley"}, {30, 59, "bedroom"}})));
  EXPECT_THAT(names(), ElementsAre("bedroom", "galley")) << "the old name stays in no list";
  EXPECT_EQ(type_of("galley"), "scullery");
  EXPECT_EQ(object_claims(*home_)->at(0).room, "galley");
  EXPECT_EQ(home_->edits()->back().what, "rename room");
}

TEST_F(RoomEdits, ARoomThatIsLeftWithoutFramesGoesFromTheListAndComesBackByUndo) {
  const std::string before = digest();
  ASSERT_OK(name_frames(*home_, kAnna, 1, labels({{0, 59, "bedroom"}})));
  EXPECT_THAT(names(), ElementsAre("bedroom"));
  undo();
  EXPECT_EQ(digest(), before);
  ASSERT_OK(name_frames(*home_, kAnna, 1, labels({{0, 59, "bedroom"}}), {"kitchen"}));
  EXPECT_THAT(names(), ElementsAre("bedroom", "kitchen")) << "photos show it";
}

TEST_F(RoomEdits, NamingAWalkAsItIsNamedChangesNothing) {
  const std::string before = digest();
  ASSERT_OK(name_frames(*home_, kAnna, 1, labels({{0, 29, "kitchen"}, {30, 59, "bedroom"}})));
  EXPECT_EQ(digest(), before);
}

TEST_F(RoomEdits, UndoRestoresTheHomeToTheBit) {
  using Change = std::function<Expected<home::EditId>()>;
  const std::vector<Change> changes{
      [&] { return set_room_type(*home_, kAnna, "kitchen", "scullery"); },
      [&] { return rename_room(*home_, kAnna, "kitchen", "galley"); },
      [&] { return divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"); },
      [&] { return move_border(*home_, kAnna, floor_, "study", "bedroom", upwards(4)); },
      [&] {
        return draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {1, 0}, {1, 1.5}, {0, 1.5}});
      },
      [&] {
        return add_door(*home_, kAnna, floor_, {"study", "bedroom"}, {4, 1});
      },
      [&] { return join_rooms(*home_, kAnna, "bedroom", "study"); },
      [&] { return remove_room(*home_, kAnna, "galley"); }};
  std::vector<std::string> digests{digest()};
  for (const Change& change : changes) {
    ASSERT_OK(change());
    digests.push_back(digest());
    EXPECT_NE(digests.back(), digests.end()[-2]);
  }
  for (std::size_t i = changes.size(); i-- > 0;) {
    undo();
    EXPECT_EQ(digest(), digests[i]) << i;
  }
}

TEST_F(RoomEdits, ARoomIsDividedByALineOnTheFloorAndInTheWalks) {
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"));
  EXPECT_EQ(room_at(4.4, 0.2), "study") << "left of who looks along the line";
  EXPECT_EQ(room_at(4.6, 1.8), "bedroom");
  EXPECT_EQ(room_at(1), "kitchen");
  EXPECT_EQ(room_of_frame(40), "study");
  EXPECT_EQ(room_of_frame(50), "bedroom");
  EXPECT_EQ(type_of("study"), "study");
}

TEST_F(RoomEdits, ALineChangesNoRoomBesideThoseThatItNames) {
  ASSERT_OK(name_frames(*home_, kAnna, 1,
                        labels({{0, 19, "kitchen"}, {20, 39, "bedroom"}, {40, 59, "bath"}})));
  const auto floor = [&](const std::string& room) {
    const auto layout = find_room_layout(*home_, floor_.frame, *floor_.grid).value().value();
    std::vector<std::pair<int, int>> cells;
    for (int row = 0; row < floor_.grid->rows(); ++row) {
      for (int column = 0; column < floor_.grid->columns(); ++column) {
        const auto index = layout.room_of_cell(column, row);
        if (index && layout.rooms()[*index].name == room) cells.emplace_back(column, row);
      }
    }
    return cells;
  };
  const auto kitchen = floor("kitchen"), bath = floor("bath");
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(3.9), "study"));
  EXPECT_EQ(floor("kitchen"), kitchen);
  EXPECT_EQ(floor("bath"), bath) << "the bedroom keeps a strip before it";
  ASSERT_OK(rename_room(*home_, kAnna, "study", "office"));
  const auto bedroom = floor("bedroom");
  ASSERT_OK(move_border(*home_, kAnna, floor_, "kitchen", "office", upwards(0.4)));
  EXPECT_EQ(floor("bedroom"), bedroom);
  EXPECT_EQ(floor("bath"), bath);
  ASSERT_OK(draw_room(*home_, kAnna, floor_, "pantry", {{0.5, 0}, {3, 0}, {3, 2}, {0.5, 2}}));
  EXPECT_EQ(floor("bedroom"), bedroom);
  EXPECT_EQ(floor("bath"), bath);
  ASSERT_OK(name_frames(*home_, kAnna, 1,
                        labels({{0, 4, "kitchen"}, {5, 49, "bedroom"}, {50, 59, "bath"}})));
  EXPECT_LT(floor("bath").size(), bath.size()) << "who names frames anew says where rooms are";
}

TEST_F(RoomEdits, ADivisionStandsWhenALaterWalkNamesTheRoomAsBefore) {
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"));
  const auto walk = add_walk("tuesday");
  ASSERT_OK(name_frames(*home_, kAnna, walk, labels({{0, 29, "kitchen"}, {30, 59, "bedroom"}})));
  EXPECT_EQ(room_at(4.4, 0.2), "study");
  EXPECT_EQ(room_at(4.6, 1.8), "bedroom");
}

TEST_F(RoomEdits, ABorderGoesWhereSomebodyMovesIt) {
  ASSERT_OK(move_border(*home_, kAnna, floor_, "kitchen", "bedroom", upwards(2)));
  EXPECT_EQ(room_at(1.9, 1.9), "kitchen");
  EXPECT_EQ(room_at(2.1, 0.1), "bedroom");
  EXPECT_EQ(room_of_frame(25), "bedroom");
}

TEST_F(RoomEdits, ADrawnRoomHasTheFloorInsideItsOutline) {
  ASSERT_OK(draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {1, 0}, {1, 1.5}, {0, 1.5}}));
  EXPECT_EQ(room_at(0.5, 0.5), "pantry");
  EXPECT_EQ(room_at(0.5, 1.8), "kitchen");
  EXPECT_EQ(room_of_frame(5), "pantry");
  EXPECT_EQ(room_of_frame(15), "kitchen");
}

TEST_F(RoomEdits, ADoorThatSomebodyAddsLeadsFromRoomToRoom) {
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"));
  ASSERT_OK(add_door(*home_, kAnna, floor_, {"kitchen", "bedroom"}, {3, 1.9}));
  const auto layout = find_room_layout(*home_, floor_.frame, *floor_.grid).value().value();
  EXPECT_THAT(layout.neighbors("kitchen"), ElementsAre("bedroom", "study"));
}

TEST_F(RoomEdits, WhatWasDrawnGoesByTheNamesOfNow) {
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"));
  ASSERT_OK(rename_room(*home_, kAnna, "study", "office"));
  EXPECT_EQ(room_at(4.4, 0.2), "office");
  ASSERT_OK(join_rooms(*home_, kAnna, "kitchen", "office"));
  EXPECT_EQ(room_at(4.4, 0.2), "kitchen");
  EXPECT_EQ(room_at(4.6, 1.8), "bedroom");
  ASSERT_OK(remove_room(*home_, kAnna, "bedroom"));
  EXPECT_NE(room_at(4.6, 1.8), "bedroom");
}

TEST_F(RoomEdits, AJoinedRoomIsTheOtherOneFromNowOn) {
  ASSERT_OK(join_rooms(*home_, kAnna, "kitchen", "bedroom"));
  EXPECT_THAT(names(), ElementsAre("kitchen"));
  EXPECT_EQ(room_at(5), "kitchen");
  EXPECT_EQ(room_of_frame(50), "kitchen");
  EXPECT_EQ(home_->room_ranges(1)->ranges().back().stay, 2);
}

TEST_F(RoomEdits, UndoingAJoinBringsBackWhatWasSaidOfBothRooms) {
  const std::vector<rooms::ObjectClaim> said{{"pan", "bedroom", true}, {"pan", "kitchen", false}};
  ASSERT_OK(store_object_claims(*home_, said));
  ASSERT_OK(join_rooms(*home_, kAnna, "kitchen", "bedroom"));
  undo();
  EXPECT_THAT(object_claims(*home_).value(), ::testing::UnorderedElementsAreArray(said));
}

TEST_F(RoomEdits, WhatSomebodySaidOfAnotherRoomMeanwhileHoldsWhenARoomComesBack) {
  ASSERT_OK(store_object_claims(*home_, std::vector<rooms::ObjectClaim>{{"pan", "bedroom", true}}));
  ASSERT_OK(remove_room(*home_, kAnna, "bedroom"));
  const std::vector<rooms::ObjectClaim> said{{"pan", "kitchen", true}};
  ASSERT_OK(store_object_claims(*home_, said));
  undo();
  EXPECT_EQ(object_claims(*home_).value(), said) << "a pan tells of one room";
}

TEST_F(RoomEdits, WhatIsToldOfLearningGoesByTheNewName) {
  learn("net", "bedroom", R"({"rooms":[{"room":"kitchen","pictures":40},{"room":"bedroom"}]})");
  const auto told = [&] { return home_->room_classifier().value()->report_json; };
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  EXPECT_EQ(told(), R"({"rooms":[{"room":"galley","pictures":40},{"room":"bedroom"}]})");
}

TEST_F(RoomEdits, WhatRoomsWereLearnedFromIsKnownByItsFrames) {
  const auto tuesday = add_walk("tuesday");
  ASSERT_OK(
      home_->put_room_classifier({"net", "a", {}, R"({"frames": [[1, 3], [2, 5], [2, 99]]})"}));
  EXPECT_THAT(learned_keyframes(*home_).value(), ElementsAre(3, 65));
  ASSERT_OK(
      home_->cull_keyframes({.culled = {10},
                             .edges = {},
                             .places = {{.recording = 1, .frame_index = 10, .place = {9, {}}}}}));
  EXPECT_THAT(learned_keyframes(*home_).value(), ElementsAre(3, 64)) << "it has another number";
  EXPECT_EQ(home_->keyframes()->at(64).recording, tuesday);
  EXPECT_EQ(home_->keyframes()->at(64).frame_index, 5U);
  ASSERT_OK(home_->put_room_classifier({"net", "a", {}, R"({"frames": [7]})"}));
  EXPECT_ERROR(learned_keyframes(*home_), "a.home: is damaged");
}

TEST_F(RoomEdits, OfRoomsTheNewestChangeIsUndoneFirst) {
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  ASSERT_OK(rename_room(*home_, {"Ben's phone", 1'753'000'009}, "bedroom", "den"));
  EXPECT_ERROR(undo_edit(*home_, home_->edits()->back().id - 1),
               "undo that first: renamed room bedroom to den");
}

TEST_F(RoomEdits, UndoingAnOldNameReachesAWalkThatCameSince) {
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  const home::EditId renamed = home_->edits()->back().id;
  const auto walk = add_walk("tuesday");
  ASSERT_OK(name_rooms(*home_, walk, labels({{0, 29, "galley"}})));
  ASSERT_OK(undo_edit(*home_, renamed));
  EXPECT_EQ(room_of_frame(3), "kitchen");
  EXPECT_EQ(room_of_frame(3, walk), "kitchen");
}

TEST_F(RoomEdits, UndoingANameOfAForgottenWalkNamesNoOtherWalkThatHasItsNumber) {
  const auto forgotten = add_walk("tuesday");
  ASSERT_OK(name_frames(*home_, kAnna, forgotten, labels({{0, 29, "kitchen"}})));
  ASSERT_OK(name_frames(*home_, kAnna, forgotten, labels({{0, 29, "bedroom"}})));
  ASSERT_OK(forget_walk(*home_, forgotten));
  const auto left = home_->edits().value();
  for (const home::Edit& edit : left) {
    EXPECT_THAT(edit.change, ::testing::Not(::testing::HasSubstr("tuesday")));
  }
  EXPECT_EQ(describe(stored_edits(*home_)->back()),
            "named rooms of a walk that was forgotten since");
  const auto walk = add_walk("wednesday");
  ASSERT_EQ(walk, forgotten) << "its number is given again";
  ASSERT_OK(name_rooms(*home_, walk, labels({{30, 59, "bedroom"}})));
  undo();
  EXPECT_EQ(room_of_frame(3, walk), "");
  EXPECT_EQ(room_of_frame(30, walk), "bedroom");
  EXPECT_EQ(room_of_frame(3), "kitchen") << "nor is another walk touched";
}

TEST_F(RoomEdits, OfARemovedRoomNothingIsLeftOnceTheHomeIsClosed) {
  ASSERT_OK(rename_room(*home_, kAnna, "bedroom", "solarium"));
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "solarium", upwards(4.5), "study"));
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  ASSERT_OK(draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {1, 0}, {1, 1.5}, {0, 1.5}}));
  ASSERT_OK(rename_room(*home_, kAnna, "pantry", "larder"));
  ASSERT_OK(remove_room(*home_, kAnna, "solarium"));
  ASSERT_OK(set_room_type(*home_, kAnna, "study", "office"));
  EXPECT_TRUE(has_removed_rooms(*home_).value());
  ASSERT_OK(forget_removed_rooms(*home_));
  EXPECT_FALSE(has_removed_rooms(*home_).value());
  const auto left = home_->edits().value();
  for (const home::Edit& edit : left) {
    for (const char* trace : {"solarium", "bedroom"}) {
      EXPECT_THAT(edit.change + edit.before, ::testing::Not(::testing::HasSubstr(trace)));
    }
  }
  ASSERT_THAT(left, SizeIs(2));
  EXPECT_EQ(left[0].what, "draw room") << "what was drawn stands, by the names of now";
  EXPECT_EQ(room_at(0.5, 0.5), "larder");
  EXPECT_ERROR(undo_edit(*home_, left[0].id), "removed for good");
  EXPECT_OK(undo_edit(*home_, left[1].id)) << "it is younger than the removal";
  EXPECT_EQ(type_of("study"), "study");
}

TEST_F(RoomEdits, OfARemovedRoomNoEarlierClassifierIsLeft) {
  const auto learn = [&](const std::string& network, const std::string& other) {
    std::vector<rooms::RoomSample> samples;
    for (std::uint64_t i = 0; i < 40; ++i) {
      const float small = 0.1F * static_cast<float>(i % 5);
      samples.push_back({{9, small, 1}, "kitchen", 1, i / 10});
      samples.push_back({{small, 9, 1}, other, 1, i / 10});
    }
    const auto learned = rooms::learn_rooms(samples, {network, network});
    ASSERT_OK(learned);
    ASSERT_OK(home_->put_room_classifier({network, network, learned->classifier.to_bytes(), "{}"}));
  };
  ASSERT_OK(name_frames(*home_, kAnna, 1,
                        labels({{0, 19, "kitchen"}, {20, 39, "bedroom"}, {40, 59, "hall"}})));
  learn("first", "bedroom");
  ASSERT_OK(remove_room(*home_, kAnna, "bedroom"));
  learn("second", "hall");
  ASSERT_THAT(home_->room_classifiers().value(), SizeIs(2));
  ASSERT_OK(forget_removed_rooms(*home_));
  EXPECT_THAT(home_->room_classifiers().value(), IsEmpty());
}

TEST_F(RoomEdits, OfARemovedRoomThingsTellNothingEither) {
  ASSERT_OK(rename_room(*home_, kAnna, "bedroom", "solarium"));
  const Eigen::Vector3d there(4, 1, 0.5);
  ASSERT_OK(add_thing(*home_, kAnna, "kettle", {there, "solarium"}));
  ASSERT_OK(add_thing(*home_, kAnna, "mug", {there, "kitchen"}));
  home::OwnThing keys{.name = "keys", .owner = "Anna"};
  keys.last_seen.room = "solarium";
  ASSERT_OK(home_->add_own_thing(keys, std::array{objects::TaughtView{}}));
  ASSERT_OK(remove_room(*home_, kAnna, "solarium"));
  ASSERT_OK(rename_room(*home_, kAnna, "kitchen", "galley"));
  ASSERT_OK(forget_removed_rooms(*home_));
  ASSERT_OK(home_->erase_removed());
  EXPECT_EQ(home_->own_things()->at(0).last_seen.room, std::nullopt);
  const auto things = find_home_things(*home_)->things;
  ASSERT_THAT(things, SizeIs(2)) << "they stay";
  EXPECT_EQ(things[0].room, std::nullopt);
  EXPECT_EQ(things[1].room, "galley");
  undo();
  EXPECT_EQ(find_home_things(*home_)->things[1].room, "kitchen");
  home_.reset();
  const std::string bytes = read_text_file(folder_ / "a.home").value();
  EXPECT_NE(bytes.find("kettle"), std::string::npos);
  EXPECT_EQ(bytes.find("solarium"), std::string::npos);
}

// Kills this process when `count` SQL statements have begun.
void kill_at_statement(home::Home& home, int* count) {
  const auto on_statement = [](unsigned, void* left, void*, void*) {
    if (--*static_cast<int*>(left) == 0) ::kill(::getpid(), SIGKILL);
    return 0;
  };
  sqlite3_trace_v2(home.database().handle(), SQLITE_TRACE_STMT, on_statement, count);
}

TEST_F(RoomEdits, AChangeAndItsUndoAreWholeOrNotThereWhereverTheProgramIsKilled) {
  const std::string before = digest();
  home_.reset();
  const auto kept = folder_ / "kept.home", tried = folder_ / "tried.home";
  std::filesystem::rename(folder_ / "a.home", kept);
  const auto begin_anew = [&] {
    for (const char* suffix : {"", "-wal", "-shm", "-lock"}) {
      std::filesystem::remove(tried.string() + suffix);
    }
    std::filesystem::copy_file(kept, tried);
  };
  begin_anew();
  home_.emplace(home::Home::open(tried).value());
  ASSERT_OK(divide_room(*home_, kAnna, floor_, "bedroom", upwards(4.5), "study"));
  const std::string after = digest();
  home_.reset();
  int killed = 0;
  for (int statement = 1;; statement += 3) {
    begin_anew();
    const int status = home::testing::run_in_child([&] {
      home::Home home = home::Home::open(tried).value();
      int left = statement;
      kill_at_statement(home, &left);
      const auto id = divide_room(home, kAnna, floor_, "bedroom", upwards(4.5), "study");
      if (!id || !undo_edit(home, *id)) return 1;
      sqlite3_trace_v2(home.database().handle(), 0, nullptr, nullptr);
      return 3;
    });
    const auto home = home::Home::open(tried);
    ASSERT_OK(home);
    const std::string now = home->content_digest().value();
    EXPECT_TRUE(now == before || now == after) << "killed at statement " << statement;
    if (!WIFSIGNALED(status)) {
      EXPECT_EQ(WEXITSTATUS(status), 3);
      EXPECT_EQ(now, before);
      break;
    }
    ++killed;
  }
  EXPECT_GT(killed, 20);
}

TEST_F(RoomEdits, ThatChangeNothingOrCannotBeAreRefused) {
  const std::string before = digest();
  const auto divide = [&](const FloorLine& line, const std::string& name = "study") {
    return divide_room(*home_, kAnna, floor_, "bedroom", line, name);
  };
  EXPECT_ERROR(divide(upwards(1)), "divides nothing");
  EXPECT_ERROR(divide({{4, 1}, {4, 1}}), "two points that are not the same");
  EXPECT_ERROR(divide({{4, std::numeric_limits<double>::infinity()}, {4, 1}}), "two points");
  EXPECT_ERROR(divide(upwards(4.5), "kitchen"), "a room 'kitchen' already");
  EXPECT_ERROR(divide(upwards(4.5), std::string(61, 'x')), "at most 60");
  EXPECT_ERROR(divide(upwards(4.5), ""), "empty");
  EXPECT_ERROR(move_border(*home_, kAnna, floor_, "bedroom", "kitchen", upwards(9)), "no floor");
  EXPECT_ERROR(move_border(*home_, kAnna, floor_, "bedroom", "bedroom", upwards(2)), "itself");
  EXPECT_ERROR(draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {1, 0}}), "3 to 100 corners");
  EXPECT_ERROR(draw_room(*home_, kAnna, floor_, "pantry", {{9, 9}, {10, 9}, {10, 10}}),
               "changes nothing");
  EXPECT_ERROR(draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {6, 0}, {6, 2}, {0, 2}}),
               "no floor; join");
  EXPECT_ERROR(add_door(*home_, kAnna, floor_, {"kitchen", "kitchen"}, {3, 1}), "two rooms");
  EXPECT_ERROR(add_door(*home_, kAnna, floor_, {"kitchen", "bedroom"}, {1e6, 1}),
               "the place (1e+06, 1), 0 m above the floor, lies far outside the map; give x from");
  EXPECT_ERROR(draw_room(*home_, kAnna, floor_, "pantry", {{0, 0}, {1e9, 0}, {1, 1}}),
               "far outside the map");
  EXPECT_ERROR(add_door(*home_, kAnna, floor_, {"kitchen", "attic"}, {3, 1}), "no room 'attic'");
  EXPECT_ERROR(join_rooms(*home_, kAnna, "kitchen", "kitchen"), "to itself");
  EXPECT_ERROR(rename_room(*home_, kAnna, "attic", "loft"), "no room 'attic'");
  EXPECT_ERROR(rename_room(*home_, kAnna, "kitchen", "bedroom"), "already");
  EXPECT_ERROR(rename_room(*home_, kAnna, "kitchen", "kitchen"), "already");
  EXPECT_ERROR(set_room_type(*home_, kAnna, "kitchen", "kitchen"), "already");
  EXPECT_ERROR(remove_room(*home_, kAnna, "attic"), "no room 'attic'");
  EXPECT_ERROR(name_frames(*home_, kAnna, 7, labels({{0, 1, "attic"}})), "no recording 7");
  floor_.grid.reset();
  EXPECT_ERROR(divide(upwards(4.5)), "no floor to draw on");
  EXPECT_EQ(digest(), before);
}

}  // namespace
}  // namespace roomwise::pipeline
