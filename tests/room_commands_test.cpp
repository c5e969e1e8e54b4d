// Rooms, command by command, with a network that sees nothing but a picture's mean colour.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;

class RoomCommandsTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 48;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::write_made_up_recording(path("walk"), kFrames));
    EXPECT_OK(write_file(path("colors.onnx"), testing::mean_color_network()));
    EXPECT_OK(write_file(path("colors.card.json"), R"({"input": {"width": 6, "height": 4}})"));
    result_of({"map", path("walk"), "--home", path("mapped.home"), "--network", path("colors.onnx"),
               "--keyframe-translation", "0.02"});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }

  // A copy of the mapped home for a test that changes it.
  static std::string copy_of_home(const std::string& name) {
    std::filesystem::copy_file(path("mapped.home"), path(name));
    return path(name);
  }
  // One folder a room, each with pictures of about one colour.
  static void write_photos(const std::string& folder) {
    const std::vector<std::pair<std::string, Rgb8>> rooms{
        {"attic", {200, 60, 60}}, {"cellar", {60, 200, 60}}, {"garage", {60, 60, 200}}};
    for (const auto& [room, color] : rooms) {
      std::filesystem::create_directories(path(folder + "/" + room));
      for (int i = 0; i < 6; ++i) {
        const auto shade = static_cast<std::uint8_t>(10 * i);
        const image::ColorImage photo(12, 8, {color.r, color.g, shade});
        EXPECT_OK(write_file(path(fmt::format("{}/{}/{}.png", folder, room, i)),
                             image::encode_png(photo)));
      }
    }
  }

  inline static std::unique_ptr<ScratchFolder> folder_;
};

TEST_F(RoomCommandsTest, RoomsOfAWalkAreLearnedEvaluatedAndRecognised) {
  const std::string home = copy_of_home("learned.home");
  const json learned =
      result_of({"rooms", "learn", "--home", home, "--network", path("colors.onnx")});
  ASSERT_EQ(learned.at("rooms").size(), 2U);
  EXPECT_EQ(learned.at("rooms")[0].at("room"), "hall");
  EXPECT_TRUE(learned.contains("sure_from"));

  write_photos("elsewhere");
  const json result =
      result_of({"rooms", "eval", "--home", home, "--recording", path("walk"), "--margin", "3",
                 "--network", path("colors.onnx"), "--baselines", "--unknown", path("elsewhere"),
                 "--unknown", path("walk"), "--report", path("rooms.html")});
  for (const char* rule : {"single", "pair", "stream", "paper_single", "paper_pair_without_objects",
                           "baseline_colors", "baseline_nearest"}) {
    ASSERT_TRUE(result.contains(rule)) << rule;
    EXPECT_EQ(result.at(rule).at("precision"), 1.0) << rule;
    EXPECT_TRUE(result.at(rule).contains("ms"));
    EXPECT_FALSE(result.at(rule).at("curve").empty());
  }
  EXPECT_EQ(result.at("single").at("n"), kFrames - 12) << "three frames at four ends of ranges";
  EXPECT_EQ(result.at("single").at("named").at("share"), 1.0);
  EXPECT_EQ(result.at("unknown").at("n"), 18 + kFrames);
  EXPECT_EQ(result.at("unknown_pair").at("n"), kFrames - 1) << "photos are not of one place";
  const json& of_photos = result.at("unknown").at("folders").at(path("elsewhere"));
  EXPECT_EQ(of_photos.at("n"), 18);
  EXPECT_EQ(of_photos.at("named"), 0.0);
  EXPECT_GT(of_photos.at("auroc"), 0.9) << "of colours that no room has";
  const json& of_walk = result.at("unknown").at("folders").at(path("walk"));
  EXPECT_EQ(of_walk.at("n"), kFrames);
  EXPECT_LT(of_walk.at("auroc"), 0.6) << "these are learned";
  EXPECT_FALSE(result.at("unknown_pair").at("folders").contains(path("elsewhere")));
  const json& along_walk = result.at("unknown_stream").at("folders");
  EXPECT_EQ(along_walk.at(path("walk")).at("n"), kFrames);
  EXPECT_GT(along_walk.at(path("walk")).at("named"), 0.8) << "these are learned";
  EXPECT_FALSE(along_walk.contains(path("elsewhere"))) << "photos are no walk";
  EXPECT_THAT(
      testing::run_roomwise({"rooms", "learn", "--home", home, "--network", "nowhere"}).errors,
      HasSubstr("nowhere: no such network"));
  EXPECT_EQ(result.at("resampled"), "visits");
  const auto page = read_text_file(path("rooms.html"));
  ASSERT_OK(page);
  EXPECT_THAT(*page, HasSubstr("two pictures: a row for each true room"));

  const auto recognize = [&](std::vector<std::string> arguments) {
    std::vector<std::string> all{"rooms", "recognize", "--home",
                                 home,    "--network", path("colors.onnx")};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return result_of(all);
  };
  const auto pictures = [] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path("walk/rgb")))
      names.push_back(entry.path());
    std::ranges::sort(names);
    return names;
  }();
  const json hall = recognize({pictures.front(), pictures[1]});
  EXPECT_EQ(hall.at("rooms")[0].at("room"), "hall");
  EXPECT_EQ(recognize({pictures[40], pictures[41], pictures[42]}).at("rooms")[0].at("room"),
            "kitchen");
  EXPECT_EQ(recognize({"--walk", "0.5", pictures[40], pictures[41], pictures[42], pictures[43]})
                .at("rooms")[0]
                .at("room"),
            "kitchen");
  const json unknown = recognize({path("elsewhere/cellar/0.png")});
  EXPECT_EQ(unknown.at("room"), nullptr) << unknown;
  EXPECT_EQ(unknown.at("verdict"), "none of them");
}

TEST_F(RoomCommandsTest, PicturesWithDepthAreRecognisedByTheirPlaceToo) {
  const std::string home = copy_of_home("placed.home");
  result_of({"rooms", "learn", "--home", home, "--network", path("colors.onnx")});
  EXPECT_OK(testing::write_made_up_recording(path("visit"), kFrames));
  const std::vector<std::string> eval{"rooms",     "eval",        "--home",     home,
                                      "--margin",  "3",           "--network",  path("colors.onnx"),
                                      "--unknown", path("visit"), "--recording"};
  const auto eval_of = [&](const std::string& recording, std::vector<std::string> more = {}) {
    more.insert(more.begin(), path(recording));
    more.insert(more.begin(), eval.begin(), eval.end());
    return result_of(more);
  };
  const json visit = eval_of("visit");
  for (const char* rule : {"single_place", "pair_place", "stream_place"}) {
    ASSERT_TRUE(visit.contains(rule)) << rule;
    EXPECT_EQ(visit.at(rule).at("precision"), 1.0) << rule;
    EXPECT_GE(visit.at(rule).at("ms"), visit.at("single").at("ms")) << rule;
    const json& walk = visit.at(rule).at("walks")[0];
    EXPECT_EQ(walk.at("walk"), "visit");
    EXPECT_EQ(walk.at("n"), visit.at(rule).at("n"));
    EXPECT_EQ(walk.at("right"), walk.at("named"));
  }
  EXPECT_EQ(visit.at("unknown_place").at("n"), kFrames);
  EXPECT_EQ(visit.at("unknown_pair_place").at("n"), kFrames - 1);
  EXPECT_EQ(visit.at("unknown_stream_place").at("n"), kFrames);
  EXPECT_FALSE(eval_of("walk").contains("single_place")) << "the map was made of it";
  EXPECT_FALSE(eval_of("visit", {"--without-places"}).contains("single_place"));

  const auto first_in = [](const std::string& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder)))
      names.push_back(entry.path());
    return *std::ranges::min_element(names);
  };
  const std::vector<std::string> recognize{"rooms",
                                           "recognize",
                                           "--home",
                                           home,
                                           "--network",
                                           path("colors.onnx"),
                                           first_in("visit/rgb")};
  const auto recognized = [&](std::vector<std::string> more) {
    more.insert(more.begin(), recognize.begin(), recognize.end());
    return result_of(more);
  };
  const std::string depth = first_in("visit/depth");
  EXPECT_EQ(recognized({"--depth", depth}).at("rooms")[0].at("room"), "hall");
  EXPECT_EQ(recognized({"--depth", depth, "--walk", "1"}).at("rooms")[0].at("room"), "hall");
  std::vector<std::string> too_many = recognize;
  too_many.insert(too_many.end(), {"--depth", depth, "--depth", depth});
  EXPECT_THAT(run_roomwise(too_many).errors, HasSubstr("1 pictures and 2 depth images"));
}

TEST_F(RoomCommandsTest, ThePapersRuleCanBeChosen) {
  const std::string home = copy_of_home("paper.home");
  result_of({"rooms", "learn", "--home", home, "--augment", "0"});
  const auto recognize = [&](const std::string& first, const std::string& second) {
    return result_of({"rooms", "recognize", "--rule", "paper", "--home", home,
                      path("walk/rgb/" + first), path("walk/rgb/" + second), "--network",
                      path("colors.onnx")});
  };
  const auto color_files = [] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path("walk/rgb")))
      names.push_back(entry.path().filename());
    std::ranges::sort(names);
    return names;
  }();
  const json hall = recognize(color_files.front(), color_files[1]);
  EXPECT_EQ(hall.at("room"), "hall");
  EXPECT_EQ(hall.at("how"), "frames agree");
  EXPECT_EQ(recognize(color_files[40], color_files[41]).at("room"), "kitchen");
  EXPECT_THAT(recognize(color_files.front(), color_files.back()).at("how"), "higher score");
  const ProgramResult three =
      run_roomwise({"rooms", "recognize", "--rule", "paper", "--home", home,
                    path("walk/rgb/" + color_files[0]), path("walk/rgb/" + color_files[1]),
                    path("walk/rgb/" + color_files[2]), "--network", path("colors.onnx")});
  EXPECT_EQ(three.exit_code, 1);
  EXPECT_THAT(three.errors, HasSubstr("one or two pictures"));
}

TEST_F(RoomCommandsTest, RoomsAreNamedByFramesAndByTime) {
  const std::string home = copy_of_home("named.home");
  json rooms = result_of(
      {"rooms", "name", "--home", home, "--frames", "0-9=porch", "--times", "1.5-4.7=loft"});
  EXPECT_THAT(rooms.at("rooms").dump(), HasSubstr("porch"));
  EXPECT_THAT(rooms.at("rooms").dump(), HasSubstr("loft"));
  rooms = result_of({"rooms", "name", "--home", home, "--types", "loft=bedroom"});
  EXPECT_THAT(rooms.at("rooms").dump(), HasSubstr(R"({"name":"loft","type":"bedroom"})"));
  const ProgramResult wrong =
      run_roomwise({"rooms", "name", "--home", home, "--frames", "9 to 12 is the porch"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.errors, HasSubstr("FIRST-LAST=ROOM"));
}

TEST_F(RoomCommandsTest, OfAHomeWithoutAWalkNothingIsToldToBeThere) {
  ASSERT_OK(home::Home::create(path("bare.home")));
  const ProgramResult bare = run_roomwise({"rooms", "coverage", "--home", path("bare.home")});
  EXPECT_EQ(bare.exit_code, 1);
  EXPECT_THAT(bare.errors, HasSubstr("bare.home: has no map yet; map a walk first"));
}

TEST_F(RoomCommandsTest, WhatTheWalksLackIsTold) {
  const std::string home = copy_of_home("coverage.home");
  const std::vector<std::string> command{"rooms", "coverage", "--home", home};
  const json found = result_of(command);
  ASSERT_EQ(found.at("rooms").size(), 2U);
  const json& hall = found.at("rooms")[0];
  EXPECT_EQ(hall.at("room"), "hall");
  ASSERT_EQ(hall.at("walks").size(), 1U);
  EXPECT_GT(hall.at("walks")[0].at("light").at("brightness"), 0);
  EXPECT_EQ(hall.at("several_lights"), false);
  const json& missing = found.at("missing");
  EXPECT_TRUE(std::ranges::any_of(missing, [](const json& one) {
    return one.at("what") == "second walk" && one.at("room") == "hall";
  })) << missing;
  EXPECT_THAT(run_roomwise(command).output, HasSubstr("hall: only one walk saw it"));
}

TEST_F(RoomCommandsTest, WhatIsSaidOfObjectsIsKeptUntilItIsUnsaid) {
  const std::string home = copy_of_home("objects.home");
  result_of({"rooms", "name", "--home", home, "--frames", "0-9=porch", "--frames", "10-19=loft"});
  const std::vector<std::string> objects = {"rooms", "objects", "--home", home};
  EXPECT_TRUE(result_of(objects).at("rooms").empty());  // its network names nothing
  const auto with = [&](const std::string& option, const std::string& claim) {
    std::vector<std::string> words = objects;
    words.insert(words.end(), {option, claim});
    return words;
  };
  json said = result_of(with("--represents", "bed=loft")).at("rooms").at("loft").at(0);
  EXPECT_EQ(said.at("object"), "bed");
  EXPECT_EQ(said.at("representative"), true);
  EXPECT_EQ(said.at("said"), true);
  // It cannot stand in two rooms alone.
  json moved = result_of(with("--represents", "bed=porch")).at("rooms");
  EXPECT_FALSE(moved.contains("loft"));
  EXPECT_EQ(moved.at("porch").at(0).at("representative"), true);
  moved = result_of(with("--represents-not", "bed=porch")).at("rooms");
  EXPECT_EQ(moved.at("porch").at(0).at("representative"), false);
  EXPECT_TRUE(result_of(with("--unsay", "bed=porch")).at("rooms").empty());
  const ProgramResult no_room = run_roomwise(with("--represents", "bed=attic"));
  EXPECT_EQ(no_room.exit_code, 1);
  EXPECT_THAT(no_room.errors, HasSubstr("no room 'attic'"));
  EXPECT_THAT(run_roomwise(with("--represents", "spaceship=loft")).errors,
              HasSubstr("no word 'spaceship'"));
  EXPECT_THAT(run_roomwise(with("--unsay", "bed=loft")).errors, HasSubstr("nobody said"));
  EXPECT_THAT(run_roomwise(with("--represents", "bed")).errors, HasSubstr("OBJECT=ROOM"));
}

TEST_F(RoomCommandsTest, NothingIsSaidOfTheTypeOfAnEmptyRoom) {
  const std::string home = copy_of_home("types.home");
  result_of({"rooms", "name", "--home", home, "--frames", "0-9=porch"});
  const json types = result_of({"rooms", "types", "--home", home, "--accept"});
  EXPECT_THAT(types.at("rooms").dump(), HasSubstr("porch"));
  for (const json& room : types.at("rooms")) {
    EXPECT_EQ(room.at("taken"), false);
    EXPECT_TRUE(room.at("guesses").at(0).at("type").is_null()) << room;
  }
}

TEST_F(RoomCommandsTest, RoomsAreLearnedFromPhotosAlone) {
  write_photos("photos");
  const std::string home = path("photos.home");
  result_of({"rooms", "learn", "--home", home, "--photos", path("photos"), "--network",
             path("colors.onnx")});
  const json result = result_of({"rooms", "eval", "--home", home, "--photos", path("photos"),
                                 "--network", path("colors.onnx")});
  EXPECT_EQ(result.at("single").at("n"), 18);
  EXPECT_GT(result.at("single").at("precision"), 0.9);
  EXPECT_EQ(result.at("paper_single").at("precision"), 1.0);
  const ProgramResult without_keyframes =
      run_roomwise({"rooms", "eval", "--home", home, "--photos", path("photos"), "--baselines",
                    "--network", path("colors.onnx")});
  EXPECT_EQ(without_keyframes.exit_code, 1);
  EXPECT_THAT(without_keyframes.errors, HasSubstr("baselines need rooms"));
}

TEST_F(RoomCommandsTest, WhatCannotBeAnsweredIsSaidInOneLine) {
  const ProgramResult unlearned =
      run_roomwise({"rooms", "recognize", "--home", path("mapped.home"), path("walk/rgb.txt"),
                    "--network", path("colors.onnx")});
  EXPECT_EQ(unlearned.exit_code, 1);
  EXPECT_THAT(unlearned.errors, HasSubstr("rooms learn"));
  const ProgramResult nothing =
      run_roomwise({"rooms", "learn", "--home", path("new.home"), "--photos", path("walk/rgb"),
                    "--network", path("colors.onnx")});
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(path("new.home"))) << "a mistake makes no home";
  const ProgramResult unused = run_roomwise({"rooms", "learn", "--home", path("mapped.home"),
                                             "--augment", "0", "--network", path("colors.onnx")});
  EXPECT_EQ(unused.exit_code, 1);
  EXPECT_THAT(unused.errors, HasSubstr("--network needs --augment or --photos"));
}

}  // namespace
}  // namespace roomwise
