// What export writes for other programs, read by readers that know nothing of Roomwise: packages of
// Python and npm, and scripts written from the formats' own documentation (tests/readers/).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "made_up_home.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kMadeUpKitchen;
using testing::kMadeUpLaterWalk;
using testing::kMadeUpLiving;
using testing::kMadeUpWalk;
using ::testing::Not;
using testing::ProgramResult;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;
using ::testing::SizeIs;

// Homes made once; all tests look at the same ones.
class ExportFormatsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::make_made_up_home(path("my.home")));
    EXPECT_OK(testing::make_made_up_home(
        path("bare.home"), {.has_rooms = false, .has_things = false, .has_depth = false}));
    EXPECT_OK(write_file(path("phrase"), std::string_view("open sesame\n")));
    std::filesystem::copy_file(path("my.home"), path("sealed.home"));
    result_of({"protect", path("sealed.home"), "--passphrase-file", path("phrase")});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }

  // What tests/readers/NAME printed, which must succeed.
  static json read_by(const std::string& reader, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(ROOMWISE_SOURCES) + "/tests/readers/" + reader);
    const ProgramResult result = testing::run_program("/usr/bin/python3", arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return json::parse(result.output, nullptr, false);
  }
  static json read_json(const std::string& file) {
    return read_by("read_home_json.py",
                   {std::string(ROOMWISE_SOURCES) + "/docs/home.schema.json", path(file)});
  }
  // What packages of npm find in the file; nothing where they are not installed.
  static std::optional<json> read_by_packages(const std::string& kind, const std::string& file) {
    const std::string sources = ROOMWISE_SOURCES;
    for (const char* package : {"@mcap/core", "@foxglove/schemas", "ajv", "gltf-validator"}) {
      if (!std::filesystem::exists(sources + "/web/node_modules/" + package)) return std::nullopt;
    }
    const ProgramResult result = testing::run_program(
        "/usr/bin/env",
        {"node", sources + "/tests/readers/read_by_packages.mjs", kind, path(file)});
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return json::parse(result.output, nullptr, false);
  }
  static std::string error_of(const std::vector<std::string>& arguments) {
    const ProgramResult result = run_roomwise(arguments);
    EXPECT_EQ(result.exit_code, 1);
    return result.errors;
  }

  static constexpr std::array kKinds{"json",        "colmap", "nerfstudio",
                                     "scene-graph", "mcap",   "indoorgml"};
  inline static std::unique_ptr<ScratchFolder> folder_;
};

TEST_F(ExportFormatsTest, JsonTellsRoomsDoorsThingsAndWalks) {
  const json told = result_of({"export", "json", "--home", path("my.home"), "-o", path("my.json")});
  EXPECT_EQ(told.at("things"), 3);
  EXPECT_EQ(told.at("things_elsewhere"), 1);
  EXPECT_EQ(told.at("keyframes_elsewhere"), 2);
  const json home = read_json("my.json");
  EXPECT_THAT(home.at("rooms"), ElementsAre(kMadeUpLiving, kMadeUpKitchen));
  for (std::size_t room = 0; room < 2; ++room) {
    const double area_m2 = home.at("areas_m2").at(room).get<double>();
    EXPECT_GE(area_m2, home.at("floor_m2").at(room).get<double>()) << "with what stands on it";
    EXPECT_NEAR(area_m2, 9, 2.5);
  }
  ASSERT_THAT(home.at("doors"), SizeIs(1));
  EXPECT_NEAR(home.at("doors").at(0).at("width_m").get<double>(), 0.9, 0.15);
  EXPECT_EQ(home.at("doors").at(0).at("walked"), true);
  EXPECT_THAT(home.at("openings"), IsEmpty());
}

TEST_F(ExportFormatsTest, TheListOfObjectsTellsTheRoomThatExportsTell) {
  result_of({"export", "json", "--home", path("my.home"), "-o", path("listed.json")});
  const json exported = read_json("listed.json").at("things");
  const json listed = result_of({"objects", "list", "--home", path("my.home")}).at("objects");
  ASSERT_EQ(listed.size(), exported.size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    EXPECT_EQ(listed[i].at("room"), exported[i].at("room")) << listed[i].at("name");
  }
  const std::string text = run_roomwise({"objects", "list", "--home", path("my.home")}).output;
  const std::size_t header = text.find("name ");
  ASSERT_LT(header, text.find("canapé")) << text;
  EXPECT_THAT(text.substr(header, text.find('\n', header) - header), HasSubstr("room"));
}

TEST_F(ExportFormatsTest, JsonPlacesThingsInTheirRooms) {
  result_of({"export", "json", "--home", path("my.home"), "-o", path("things.json")});
  const json things = read_json("things.json").at("things");
  ASSERT_THAT(things, SizeIs(3));
  EXPECT_EQ(things[0].at("name"), "canapé \"3\"");
  EXPECT_EQ(things[0].at("room"), kMadeUpLiving);
  EXPECT_EQ(things[0].at("room_by_place"), kMadeUpLiving) << "its middle lies in the polygon";
  EXPECT_NEAR(things[0].at("lowest_m").get<double>(), 0, 0.05) << "it stands on the floor";
  EXPECT_NEAR(things[0].at("highest_m").get<double>(), 0.7, 0.05);
  EXPECT_EQ(things[1].at("room_by_place"), kMadeUpKitchen);
  EXPECT_EQ(things[2].at("piece"), 1);
  EXPECT_EQ(things[2].at("room_by_place"), nullptr) << "nothing says where its piece lies";
  EXPECT_EQ(things[2].at("room"), kMadeUpKitchen) << "as the walk was named there";
}

TEST_F(ExportFormatsTest, JsonTellsWhereWalksLed) {
  result_of({"export", "json", "--home", path("my.home"), "-o", path("walks.json")});
  const json home = read_json("walks.json");
  const json& walks = home.at("walks");
  ASSERT_THAT(walks, SizeIs(2));
  EXPECT_EQ(walks[0].at("name"), kMadeUpWalk);
  EXPECT_EQ(walks[0].at("keyframes_elsewhere"), 0);
  for (const json& height_m : walks[0].at("heights_m")) {
    EXPECT_NEAR(height_m.get<double>(), 1.4, 0.03);
  }
  EXPECT_EQ(walks[1].at("name"), kMadeUpLaterWalk);
  EXPECT_EQ(walks[1].at("frames"), 6);
  EXPECT_EQ(walks[1].at("placed"), 4);
  EXPECT_EQ(walks[1].at("path"), 4);
  EXPECT_EQ(walks[1].at("keyframes_elsewhere"), 2);
  for (const json& look : home.at("looks")) {
    EXPECT_LT(look.at(2).get<double>(), -0.3) << "the camera looks down";
  }
}

TEST_F(ExportFormatsTest, AHomeWithoutRoomsThingsAndDepthIsToldAsItIs) {
  const ProgramResult said =
      run_roomwise({"export", "json", "--home", path("bare.home"), "-o", path("bare.json")});
  EXPECT_EQ(said.exit_code, 0) << said.errors;
  EXPECT_THAT(said.output, HasSubstr("the map shows no floor"));
  EXPECT_THAT(said.output, HasSubstr("no rooms are named"));
  EXPECT_THAT(said.output, HasSubstr("2 key-frames and 0 things lie in pieces"));
  const json home = read_json("bare.json");
  EXPECT_THAT(home.at("rooms"), IsEmpty());
  EXPECT_THAT(home.at("things"), IsEmpty());
  EXPECT_EQ(home.at("floor_found"), false);
  EXPECT_THAT(home.at("walks"), SizeIs(2));
}

TEST_F(ExportFormatsTest, ColmapSeesPointsWhereThePicturesShowThem) {
  const json told =
      result_of({"export", "colmap", "--home", path("my.home"), "-o", path("colmap")});
  EXPECT_EQ(told.at("pictures"), 41);
  EXPECT_EQ(told.at("keyframes_elsewhere"), 2);
  const json model = read_by("read_colmap.py", {path("colmap")});
  EXPECT_THAT(model.at("models"), ElementsAre("FULL_OPENCV", "PINHOLE"));
  EXPECT_THAT(model.at("images"), SizeIs(41));
  EXPECT_EQ(model.at("points"), told.at("points"));
  EXPECT_GT(model.at("points").get<int>(), 3000);
  EXPECT_LT(model.at("farthest_px").get<double>(), 0.01);
  EXPECT_LE(model.at("own_color_difference").get<int>(), 2);
  EXPECT_LE(model.at("color_difference_median").get<double>(), 3) << "in all other pictures";
}

TEST_F(ExportFormatsTest, NerfstudioSeesPointsWhereDepthShowsThem) {
  const json told =
      result_of({"export", "nerfstudio", "--home", path("my.home"), "-o", path("scene/")});
  const json scene = read_by("read_nerfstudio.py", {path("scene")});
  EXPECT_EQ(scene.at("frames"), 41);
  EXPECT_THAT(scene.at("walks"), ElementsAre(kMadeUpWalk, kMadeUpLaterWalk));
  EXPECT_EQ(scene.at("sizes"), (json{{160, 120}, {192, 128}}));
  EXPECT_EQ(scene.at("points"), told.at("points"));
  EXPECT_GT(scene.at("shown").get<double>(), 0.95) << "but where a pixel spans 2 cm of depth";
  EXPECT_LE(scene.at("color_difference_median").get<double>(), 3);
  EXPECT_NEAR(scene.at("lowest_point_m").get<double>(), 0, 0.05) << "z is up, 0 the floor";
  EXPECT_NEAR(scene.at("heights_m").at(0).get<double>(), 1.3, 0.05);
  EXPECT_NEAR(scene.at("heights_m").at(1).get<double>(), 1.4, 0.05);
  EXPECT_LT(scene.at("looks_up").get<double>(), -0.3) << "all cameras look down";
}

TEST_F(ExportFormatsTest, PicturesAreGivenWithoutTheirExif) {
  result_of({"export", "colmap", "--home", path("my.home"), "--walk", kMadeUpLaterWalk, "-o",
             path("later")});
  const json model = read_by("read_colmap.py", {path("later")});
  EXPECT_THAT(model.at("models"), ElementsAre("PINHOLE"));
  EXPECT_THAT(model.at("images"), ElementsAre("walk-1-000000.png", "walk-1-000001.jpg",
                                              "walk-1-000002.jpg", "walk-1-000003.jpg"));
  EXPECT_LE(model.at("own_color_difference").get<int>(), 2) << "turned as the camera model is";
}

TEST_F(ExportFormatsTest, ASceneGraphHasTheHomesRoomsAndThings) {
  result_of({"export", "scene-graph", "--home", path("my.home"), "-o", path("graph.json")});
  const json graph = read_by("read_scene_graph.py", {path("graph.json")});
  EXPECT_EQ(graph.at("layers"),
            (json{{"OBJECTS", 2}, {"PLACES", 3}, {"ROOMS", 4}, {"BUILDINGS", 5}}));
  const json& nodes = graph.at("nodes");
  ASSERT_THAT(nodes, SizeIs(5)) << "what lies in another piece has no place in it";
  EXPECT_EQ(nodes[0].at("symbol"), "B0");
  EXPECT_EQ(nodes[1].at("name"), kMadeUpLiving);
  EXPECT_EQ(nodes[2].at("name"), kMadeUpKitchen);
  EXPECT_EQ(nodes[1].at("symbol"), "R0");
  EXPECT_EQ(nodes[1].at("parents"), json{"home"});
  ASSERT_THAT(nodes[1].at("siblings"), SizeIs(1)) << "a door leads to the other room";
  EXPECT_EQ(nodes[1].at("siblings")[0].at("name"), kMadeUpKitchen);
  EXPECT_NEAR(nodes[1].at("box").at("size")[0].get<double>(), 3 * (std::cos(0.3) + std::sin(0.3)),
              0.3)
      << "3 m by 3 m, from a frame that is turned by 0.3 rad";
  EXPECT_EQ(nodes[3].at("name"), "canapé \"3\"");
  EXPECT_EQ(nodes[3].at("parents"), json{kMadeUpLiving});
  EXPECT_NEAR(nodes[3].at("position")[2].get<double>(), 0.35, 0.05);
  EXPECT_EQ(nodes[3].at("metadata").at("probability"), 0.875);
  EXPECT_EQ(nodes[4].at("parents"), json{kMadeUpKitchen});
}

TEST_F(ExportFormatsTest, ASceneGraphHasThePlacesOfTheRoomsFloor) {
  result_of({"export", "scene-graph", "--home", path("my.home"), "-o", path("places.json")});
  const json graph = read_by("read_scene_graph.py", {path("places.json")});
  const json& places = graph.at("places");
  // Each room is 3 m by 3 m less a box and what lies close to walls.
  for (const char* room : {kMadeUpLiving, kMadeUpKitchen}) {
    EXPECT_GE(places.at("of_rooms").at(room), 16) << room;
    EXPECT_LE(places.at("of_rooms").at(room), 64) << room;
  }
  EXPECT_EQ(places.at("pieces"), 1) << "one can walk from each to each";
  EXPECT_EQ(places.at("outside_their_room"), 0);
  EXPECT_GE(places.at("least_distance_m").get<double>(), 0.2);
  EXPECT_LE(places.at("longest_edge_m").get<double>(), 1.2) << "of neighbours";
  ASSERT_THAT(places.at("between_rooms"), Not(IsEmpty()));
  const json& door = graph.at("nodes")[1].at("siblings")[0].at("door_m");
  for (const json& way : places.at("between_rooms")) {
    EXPECT_LE(std::hypot(way[0].get<double>() - door[0].get<double>(),
                         way[1].get<double>() - door[1].get<double>()),
              1)
        << "through the door alone";
  }
}

TEST_F(ExportFormatsTest, ASceneGraphOfAHomeWithoutRoomsAndThingsIsABuilding) {
  result_of({"export", "scene-graph", "--home", path("bare.home"), "-o", path("bare-graph.json")});
  const json graph = read_by("read_scene_graph.py", {path("bare-graph.json")});
  EXPECT_THAT(graph.at("nodes"), SizeIs(1));
  EXPECT_EQ(graph.at("places").at("count"), 0);
}

TEST_F(ExportFormatsTest, AWalkPlaysBackWithItsPicturesPosesAndThings) {
  const json told = result_of({"export", "mcap", "--home", path("my.home"), "--walk", kMadeUpWalk,
                               "-o", path("first.mcap")});
  EXPECT_EQ(told.at("poses"), 37);
  const json log = read_by("read_mcap.py", {path("first.mcap")});
  const auto prompts = log.at("prompts").size();
  EXPECT_EQ(log.at("topics"), (json{{"/tf", {"foxglove.FrameTransform", 37}},
                                    {"/camera/image", {"foxglove.CompressedImage", 37}},
                                    {"/camera/calibration", {"foxglove.CameraCalibration", 37}},
                                    {"/map", {"foxglove.PointCloud", 1}},
                                    {"/things", {"foxglove.SceneUpdate", 1}},
                                    {"/rooms", {"foxglove.SceneUpdate", 1}},
                                    {"/prompts", {"foxglove.Log", prompts}}}));
  EXPECT_EQ(log.at("frames"), json::array({json::array({"home", "camera"})}));
  EXPECT_EQ(log.at("points"), told.at("points"));
  EXPECT_NEAR(log.at("lowest_point_m").get<double>(), 0, 0.05);
  EXPECT_LE(log.at("color_difference_median").get<double>(), 4)
      << "points project to where the pictures show them";
  ASSERT_THAT(log.at("things"), SizeIs(2));
  EXPECT_EQ(log.at("things")[0].at("name"), "canapé \"3\"");
  EXPECT_NEAR(log.at("things")[0].at("bottom_m").get<double>(), 0, 0.05);
}

TEST_F(ExportFormatsTest, PackagesThatOthersMadeFindNothingWrong) {
  const json told = result_of({"export", "mcap", "--home", path("my.home"), "--walk", kMadeUpWalk,
                               "-o", path("others.mcap")});
  const auto walk = read_by_packages("mcap", "others.mcap");
  if (!walk) GTEST_SKIP() << "web/node_modules has not all packages: 'npm ci' in web/ fetches them";
  EXPECT_THAT(walk->at("violations"), IsEmpty()) << "of Foxglove's own schemas";
  EXPECT_EQ(walk->at("topics").at("/tf"), told.at("poses"));
  EXPECT_EQ(walk->at("topics").at("/prompts"), told.at("prompts"));
  EXPECT_EQ(walk->at("topics").at("/things"), 1);
  EXPECT_EQ(walk->at("topics").at("/rooms"), 1);
  int messages = 0;
  for (const json& count : walk->at("topics")) messages += count.get<int>();
  EXPECT_EQ(walk->at("streamed"), messages);
  EXPECT_EQ(walk->at("in_order"), true);
  EXPECT_EQ(walk->at("ended"), true);

  result_of({"export", "json", "--home", path("my.home"), "-o", path("others.json")});
  EXPECT_THAT(read_by_packages("json", "others.json")->at("violations"), IsEmpty());

  result_of({"export", "glb", "--home", path("my.home"), "-o", path("others.glb")});
  const auto surface = read_by_packages("glb", "others.glb");
  EXPECT_THAT(surface->at("violations"), IsEmpty());
  EXPECT_GT(surface->at("triangles").get<int>(), 1000);
}

TEST_F(ExportFormatsTest, AWalkPlaysBackWithRoomsAndWhatIsSaidOnEnteringThem) {
  const json told = result_of({"export", "mcap", "--home", path("my.home"), "--walk", kMadeUpWalk,
                               "--language", "de", "-o", path("said.mcap")});
  const json log = read_by("read_mcap.py", {path("said.mcap")});
  const json& rooms = log.at("rooms");
  ASSERT_THAT(rooms, SizeIs(2));
  EXPECT_EQ(told.at("rooms"), 2);
  result_of({"export", "json", "--home", path("my.home"), "-o", path("said.json")});
  const json plan = read_json("said.json");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rooms[i].at("name"), plan.at("rooms")[i]);
    EXPECT_NEAR(rooms[i].at("area_m2").get<double>(), plan.at("areas_m2")[i].get<double>(), 1e-6);
    EXPECT_NEAR(rooms[i].at("height_m").get<double>(), 0, 1e-6);
  }
  const json& prompts = log.at("prompts");
  ASSERT_GE(prompts.size(), 2U) << "the walk goes through both rooms";
  EXPECT_EQ(told.at("prompts"), prompts.size());
  std::string last;
  for (const json& prompt : prompts) {
    ASSERT_THAT(prompt.at("in"), SizeIs(1));
    const std::string room = prompt.at("in")[0];
    EXPECT_THAT(prompt.at("text").get<std::string>(),
                ::testing::AllOf(HasSubstr(room), HasSubstr("Jetzt")));
    EXPECT_NE(room, last) << "a room is called out when it is entered";
    last = room;
  }
  EXPECT_THAT(error_of({"export", "mcap", "--home", path("my.home"), "--language", "la", "-o",
                        path("latin.mcap")}),
              HasSubstr("la"));
}

TEST_F(ExportFormatsTest, AWalkInPiecesPlaysBackWhatIsOnTheMap) {
  const ProgramResult said =
      run_roomwise({"export", "mcap", "--home", path("my.home"), "-o", path("later.mcap")});
  EXPECT_EQ(said.exit_code, 0) << said.errors;
  EXPECT_THAT(said.output, HasSubstr("wrote 4 poses, 4 pictures"));
  EXPECT_THAT(said.output, HasSubstr("2 key-frames of the walk lie in pieces"));
  const json log = read_by("read_mcap.py", {path("later.mcap")});
  EXPECT_EQ(log.at("topics").at("/camera/image")[1], 4);
  EXPECT_LE(log.at("color_difference_median").get<double>(), 4);
  result_of({"export", "mcap", "--home", path("bare.home"), "-o", path("bare.mcap")});
  const json bare = read_by("read_mcap.py", {path("bare.mcap")});
  for (const char* topic : {"/map", "/things", "/rooms", "/prompts"})
    EXPECT_FALSE(bare.at("topics").contains(topic)) << topic << ": the home has nothing of it";
}

TEST_F(ExportFormatsTest, PicturesWithoutDepthHaveNoPoints) {
  for (const char* kind : {"colmap", "nerfstudio"}) {
    const std::string output = path(std::string("bare-") + kind);
    const ProgramResult said =
        run_roomwise({"export", kind, "--home", path("bare.home"), "-o", output});
    EXPECT_EQ(said.exit_code, 0) << said.errors;
    EXPECT_THAT(said.output, HasSubstr("2 key-frames lie in pieces"));
    EXPECT_THAT(said.output, HasSubstr("no picture has depth: there are no points"));
  }
  EXPECT_EQ(read_by("read_colmap.py", {path("bare-colmap")}).at("points"), 0);
  EXPECT_EQ(read_by("read_nerfstudio.py", {path("bare-nerfstudio")}).at("depth_pixels"), 0);
}

TEST_F(ExportFormatsTest, WhatIsThereIsNotOverwritten) {
  EXPECT_OK(write_file(path("there.json"), std::string_view("mine")));
  for (const char* kind : kKinds) {
    EXPECT_THAT(error_of({"export", kind, "--home", path("my.home"), "-o", path("there.json")}),
                HasSubstr("there.json: is there and is not overwritten"));
    EXPECT_EQ(error_of({"export", kind, "--home", path("my.home"), "-o", path("no/x")}).empty(),
              false);
  }
  EXPECT_EQ(read_text_file(path("there.json")).value(), "mine");
  EXPECT_THAT(error_of({"export", "json", "--home", path("my.home"), "-o", path("no/x.json")}),
              HasSubstr("x.json"));
  EXPECT_THAT(error_of({"export", "json", "--home", path("my.home"), "-o", "/dev/full"}),
              HasSubstr("/dev/full"));
}

TEST_F(ExportFormatsTest, WhatNeedsPicturesNeedsThePassphrase) {
  const std::string home = path("sealed.home");
  for (const char* kind : kKinds) {
    const std::string output = path(std::string("sealed.") + kind);
    EXPECT_THAT(error_of({"export", kind, "--home", home, "-o", output}),
                HasSubstr("sealed.home: its pictures are protected by a passphrase"));
    for (const auto& entry : std::filesystem::directory_iterator(folder_->path())) {
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".partial")));
    }
    EXPECT_FALSE(std::filesystem::exists(output));
    result_of({"export", kind, "--home", home, "-o", output, "--passphrase-file", path("phrase")});
  }
}

}  // namespace
}  // namespace roomwise
