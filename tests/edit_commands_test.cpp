// A home changed by hand, command by command, and the changes taken back.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "made_up_home.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;

class EditCommandsTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_OK(testing::make_made_up_home(home_)); }

  static std::vector<std::string> with_home(std::vector<std::string> words,
                                            const std::string& home) {
    words.insert(words.begin(), "edit");
    words.insert(words.end(), {"--home", home});
    return words;
  }
  json edit(const std::vector<std::string>& words) { return result_of(with_home(words, home_)); }
  std::string failure_of(const std::vector<std::string>& words, int code = 1) {
    const auto result = run_roomwise(with_home(words, home_));
    EXPECT_EQ(result.exit_code, code);
    return result.errors;
  }
  json things() { return result_of({"objects", "list", "--home", home_}).at("objects"); }
  std::vector<std::string> names() {
    std::vector<std::string> names;
    for (const json& one : things()) names.push_back(one.at("name"));
    return names;
  }
  std::vector<std::string> rooms() {
    std::vector<std::string> names;
    const json layout = result_of({"rooms", "layout", "--home", home_});
    for (const json& one : layout.at("rooms")) names.push_back(one.at("name"));
    return names;
  }
  std::string digest() { return home::Home::open_read_only(home_)->content_digest().value(); }

  ScratchFolder folder_;
  std::string home_ = folder_ / "a.home";
};

TEST_F(EditCommandsTest, AThingIsRenamedNotedAndListedAsSaid) {
  EXPECT_EQ(edit({"rename-thing", "table#2", "desk"}).at("did"), "renamed table to desk");
  edit({"note", "desk", "mind the corner"});
  EXPECT_THAT(names(), ElementsAre("canapé \"3\"", "table", "desk"));
  const json desk = things()[2];
  EXPECT_EQ(desk.at("note"), "mind the corner");
  EXPECT_EQ(desk.at("by_hand"), true);
  EXPECT_EQ(desk.at("probability"), 1.0);
  EXPECT_EQ(result_of({"info", home_}).at("changed_by_hand"), 2);
}

// The made-up home's walks have two pictures that could not be joined to the rest.
TEST_F(EditCommandsTest, InfoTellsFramesThatAreNotOnTheMapApart) {
  const json info = result_of({"info", home_});
  EXPECT_GE(info.at("frames_placed").get<int>() - info.at("frames_on_the_map").get<int>(), 2);
  int on_map = 0;
  for (const json& one : info.at("recordings")) on_map += one.at("on_map").get<int>();
  EXPECT_EQ(info.at("frames_on_the_map"), on_map);
  EXPECT_GT(on_map, 0);
}

TEST_F(EditCommandsTest, ThingsAreAddedMovedMergedAndRemoved) {
  edit({"add-thing", "kettle", "--room", testing::kMadeUpKitchen, "--note", "hot"});
  EXPECT_EQ(things().back().at("room"), testing::kMadeUpKitchen);
  edit({"move-thing", "kettle", "--at", "0.2", "0.1", "--height", "0.9"});
  edit({"add-way-out", "--at", "0", "0"});
  edit({"merge-things", "table#1", "kettle"});
  edit({"remove-thing", "canapé \"3\""});
  EXPECT_THAT(names(), ElementsAre("table", "table", "way out"));
}

TEST_F(EditCommandsTest, EveryChangeIsTakenBackToTheBit) {
  std::vector<std::string> digests{digest()};
  const std::vector<std::vector<std::string>> changes{
      {"rename-thing", "table#1", "desk"},
      {"add-thing", "kettle", "--at", "0.2", "0.1"},
      {"room-type", testing::kMadeUpKitchen, "scullery"},
      {"rename-room", testing::kMadeUpKitchen, "galley"},
      {"remove-room", "galley"}};
  for (const auto& change : changes) {
    edit(change);
    digests.push_back(digest());
  }
  const json listed = edit({"list"}).at("changes");
  ASSERT_EQ(listed.size(), 5U);
  EXPECT_EQ(listed[3].at("did"), "renamed room kitchen, new to galley");
  EXPECT_EQ(listed[3].at("by"), "command line");
  EXPECT_THAT(failure_of({"undo", "4"}), HasSubstr("undo that first: removed room galley"));
  for (std::size_t i = changes.size(); i-- > 0;) {
    edit({"undo"});
    EXPECT_EQ(digest(), digests[i]) << changes[i][0];
  }
  EXPECT_THAT(failure_of({"undo"}), HasSubstr("nothing was changed by hand"));
}

TEST_F(EditCommandsTest, HistoryNamesTheRoomThatTheListNames) {
  edit({"move-thing", "canapé \"3\"", "--room", testing::kMadeUpKitchen});
  const json listed = things();
  const json told = result_of({"objects", "history", "--home", home_}).at("things");
  ASSERT_EQ(told.size(), listed.size());
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_EQ(told[i].at("room"), listed[i].at("room"));
  EXPECT_EQ(told[0].at("room"), testing::kMadeUpKitchen);
}

TEST_F(EditCommandsTest, PlacesFarOutsideTheMapAreRefused) {
  const std::string before = digest();
  for (const std::vector<std::string>& far : {std::vector<std::string>{"--at", "1e300", "0"},
                                              {"--at", "0", "-50"},
                                              {"--at", "0", "0", "--height", "80"}}) {
    std::vector<std::string> words{"add-thing", "kettle"};
    words.insert(words.end(), far.begin(), far.end());
    EXPECT_THAT(failure_of(words), HasSubstr("lies far outside the map; give x from "));
  }
  EXPECT_EQ(digest(), before);
}

TEST_F(EditCommandsTest, AnUndoOfNoChangeChangesNothing) {
  edit({"rename-thing", "table#2", "desk"});
  EXPECT_THAT(failure_of({"undo", "0"}), HasSubstr("has no change 0"));
  EXPECT_THAT(names(), ElementsAre("canapé \"3\"", "table", "desk"));
}

TEST_F(EditCommandsTest, HintsCanBePastedWhereTheHomesPathHasBlanks) {
  std::filesystem::rename(home_, folder_ / "my own.home");
  home_ = folder_ / "my own.home";
  EXPECT_THAT(run_roomwise(with_home({"rename-thing", "table#2", "desk"}, home_)).output,
              HasSubstr("--home '" + home_ + "')"));
  EXPECT_THAT(failure_of({"rename-thing", "dragon", "desk"}), HasSubstr("--home '" + home_ + "'"));
}

TEST_F(EditCommandsTest, RoomsAreDividedAndJoined) {
  const json layout = result_of({"rooms", "layout", "--home", home_});
  const json middle = layout.at("rooms")[0].at("middle_m");
  const std::string room = layout.at("rooms")[0].at("name");
  const auto number = [](double value) { return fmt::format("{:.3f}", value); };
  const double x = middle[0], y = middle[1];
  edit({"divide-room", room, "nook", "--line", number(x - 1), number(y), number(x + 1), number(y)});
  EXPECT_EQ(std::ranges::count(rooms(), "nook"), 1);
  edit({"join-rooms", room, "nook"});
  EXPECT_EQ(std::ranges::count(rooms(), "nook"), 0);
  EXPECT_THAT(failure_of({"divide-room", room, "nook", "--line", "90", "90", "91", "90"}),
              HasSubstr("divides nothing"));
}

TEST_F(EditCommandsTest, WhatIsRemovedGoesForGoodWhenThatIsSaid) {
  edit({"remove-room", testing::kMadeUpKitchen});
  EXPECT_EQ(edit({"forget"}).at("forgotten"), true);
  EXPECT_THAT(failure_of({"undo"}), HasSubstr("nothing was changed by hand"));
  EXPECT_EQ(edit({"forget"}).at("forgotten"), false);
}

TEST_F(EditCommandsTest, BadInputIsToldWithTheMend) {
  EXPECT_THAT(failure_of({"rename-thing", "table", "desk"}), HasSubstr("table#1 to table#2"));
  EXPECT_THAT(failure_of({"rename-thing", "table#3", "desk"}), HasSubstr("objects list"));
  EXPECT_THAT(failure_of({"rename-thing", "table#1", ""}), HasSubstr("empty"));
  EXPECT_THAT(failure_of({"rename-thing", "table#1", std::string(61, 'x')}),
              HasSubstr("at most 60"));
  EXPECT_THAT(failure_of({"add-thing", "kettle"}), HasSubstr("needs a place"));
  EXPECT_THAT(failure_of({"add-thing", "kettle", "--room", "attic"}), HasSubstr("no room 'attic'"));
  EXPECT_THAT(failure_of({"draw-room", "nook", "--outline", "0", "0", "1", "0", "1", "1", "2"}),
              HasSubstr("pairs"));
  failure_of({"draw-room", "nook", "--outline", "0", "0", "1"}, 2);
  EXPECT_THAT(failure_of({"undo", "7"}), HasSubstr("nothing was changed by hand"));
  failure_of({"add-door", testing::kMadeUpKitchen, testing::kMadeUpLiving}, 2);
  EXPECT_EQ(edit({"list"}).at("changes").size(), 0U);
}

}  // namespace
}  // namespace roomwise
