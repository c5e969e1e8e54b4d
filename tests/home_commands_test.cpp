// From a recording to a home and what is made of it, command by command.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;

// A home mapped from a made-up recording; all tests look at the same one.
class HomeCommandsTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 24;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::write_made_up_recording(*folder_ / "walk", kFrames));
    mapped_ = result_of({"map", path("walk"), "--no-networks", "--home", path("my.home")});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }
  // By name.
  static std::string first_file(const std::string& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder))) {
      names.push_back(entry.path().filename());
    }
    return *std::ranges::min_element(names);
  }

  inline static std::unique_ptr<ScratchFolder> folder_;
  inline static json mapped_;
};

TEST_F(HomeCommandsTest, MapPlacesEveryFrameWhereTheCameraWas) {
  EXPECT_EQ(mapped_.at("frames"), kFrames);
  EXPECT_EQ(mapped_.at("placed"), kFrames);
  const json exported =
      result_of({"export", "tum", "--home", path("my.home"), "-o", path("trajectory.txt")});
  EXPECT_EQ(exported.at("poses"), kFrames);
  const json error = result_of({"eval", "trajectory", "--truth", path("walk"), "--estimate",
                                path("trajectory.txt"), "--plot", path("plot.svg")});
  EXPECT_EQ(error.at("pairs"), kFrames);
  EXPECT_LT(error.at("ate_rmse_m").get<double>(), 0.01);
  EXPECT_THAT(read_text_file(path("plot.svg")).value(), HasSubstr("<svg"));
}

TEST_F(HomeCommandsTest, ExportWritesTheCloudAndThePoseGraph) {
  const json ply = result_of({"export", "ply", "--home", path("my.home"), "-o", path("my.ply")});
  EXPECT_GT(ply.at("points").get<int>(), 1000);
  EXPECT_THAT(read_text_file(path("my.ply")).value(), HasSubstr("element vertex"));
  const json graph = result_of({"export", "g2o", "--home", path("my.home"), "-o", path("my.g2o")});
  EXPECT_EQ(graph.at("poses"), mapped_.at("keyframes"));
  const json info = result_of({"info", path("my.g2o")});
  EXPECT_EQ(info.at("poses"), mapped_.at("keyframes"));
}

TEST_F(HomeCommandsTest, ExportWritesTheSurface) {
  const std::string home = path("my.home");
  const json mesh =
      result_of({"export", "ply", "--surface", "mesh", "--home", home, "-o", path("mesh.ply")});
  EXPECT_GT(mesh.at("triangles").get<int>(), 1000);
  EXPECT_THAT(read_text_file(path("mesh.ply")).value(), HasSubstr("element face"));
  const json glb = result_of({"export", "glb", "--home", home, "-o", path("my.glb")});
  EXPECT_EQ(glb.at("triangles"), mesh.at("triangles"));
  EXPECT_EQ(glb.at("floor_found"), false) << "there is only a wall";
  EXPECT_EQ(glb.at("level_from_world").at("quaternion_xyzw").size(), 4U);
  EXPECT_THAT(read_text_file(path("my.glb")).value(), ::testing::StartsWith("glTF"));
  result_of({"export", "glb", "--home", home, "-o", path("again.glb"), "--threads", "1"});
  EXPECT_TRUE(read_file(path("again.glb")).value() == read_file(path("my.glb")).value())
      << "at another number of threads";
}

TEST_F(HomeCommandsTest, ExportWritesForRobots) {
  const std::string home = path("my.home");
  const json pcd = result_of({"export", "pcd", "--home", home, "-o", path("my.pcd")});
  EXPECT_THAT(read_text_file(path("my.pcd")).value(),
              HasSubstr("POINTS " + pcd.at("points").dump() + "\nDATA binary\n"));
  const json octomap = result_of({"export", "octomap", "--home", home, "-o", path("my.bt")});
  EXPECT_GT(octomap.at("occupied").get<int>(), 100);
  EXPECT_GT(octomap.at("free").get<int>(), octomap.at("occupied").get<int>());
  EXPECT_THAT(read_text_file(path("my.bt")).value(),
              ::testing::StartsWith("# Octomap OcTree binary file\n"));
}

TEST_F(HomeCommandsTest, ExportOfAFloorNeedsAFloor) {
  const std::string home = path("my.home");
  const ProgramResult none =
      run_roomwise({"export", "floor", "--home", home, "-o", path("floor.yaml")});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("my.home: the map shows no floor"));
  EXPECT_FALSE(std::filesystem::exists(path("floor.yaml")));
  EXPECT_FALSE(std::filesystem::exists(path("floor.pgm")));
}

TEST_F(HomeCommandsTest, RoomsLieOnAFloor) {
  const ProgramResult none = run_roomwise({"rooms", "layout", "--home", path("my.home")});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("the map shows no floor; walk with the camera tilted down"));
  const ProgramResult nowhere = run_roomwise(
      {"rooms", "layout", "--home", path("my.home"), "--plan", path("nowhere/plan.svg")});
  EXPECT_THAT(nowhere.errors, HasSubstr("no such folder to draw the plan in"))
      << "before the map is fused";
}

TEST_F(HomeCommandsTest, OnlyASimulatedHomeHasATrueFloor) {
  const ProgramResult none =
      run_roomwise({"eval", "floor", "--home", path("my.home"), "--truth", path("walk")});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("floorplan.json"));
  EXPECT_EQ(run_roomwise({"eval", "floor", "--home", path("my.home")}).exit_code, 2);
  EXPECT_EQ(run_roomwise({"eval", "map", "--home", path("my.home"), "--truth", path("walk"),
                          "--surface", "fog"})
                .exit_code,
            2);
}

TEST_F(HomeCommandsTest, ExportSaysWhatIsWrong) {
  const std::string home = path("my.home");
  for (const std::vector<std::string>& usage :
       std::vector<std::vector<std::string>>{{"ply", "-o", path("x.ply"), "--surface", "fog"},
                                             {"glb", "-o", path("x.glb"), "--voxel", "0"},
                                             {"glb"},
                                             {"octomap", "-o", path("x.bt"), "--cell", "-1"},
                                             {"floor", "-o", path("x.pgm")}}) {
    std::vector<std::string> command{"export", usage.front(), "--home", home};
    command.insert(command.end(), usage.begin() + 1, usage.end());
    EXPECT_EQ(run_roomwise(command).exit_code, 2) << usage.front();
  }
  const auto error_of = [&](std::vector<std::string> command) {
    command.insert(command.begin(), "export");
    const ProgramResult result = run_roomwise(command);
    EXPECT_EQ(result.exit_code, 1);
    return result.errors;
  };
  EXPECT_THAT(error_of({"glb", "--home", path("absent.home"), "-o", path("x.glb")}),
              HasSubstr("absent.home"));
  EXPECT_THAT(error_of({"octomap", "--home", home, "-o", path("no/x.bt")}), HasSubstr("x.bt"));
  EXPECT_THAT(error_of({"glb", "--home", home, "-o", path("x.glb"), "--voxel", "5"}),
              HasSubstr("voxel_size_m"));
  EXPECT_THAT(error_of({"octomap", "--home", home, "-o", path("x.bt"), "--cell", "0.5"}),
              HasSubstr("cells of 0.5 m do not go with voxels of 0.02 m"));
  EXPECT_THAT(error_of({"floor", "--home", home, "-o", path("x.yaml"), "--cell", "0.02"}),
              HasSubstr("cells of 0.02 m"));
  EXPECT_THAT(error_of({"floor", "--home", home, "-o", path("x.yaml"), "--height", "0.1"}),
              HasSubstr("person_height_m"));
  for (const char* cloud : {"ply", "pcd"}) {
    for (const char* voxel : {"1e-6", "1e-9", "1.5"}) {
      EXPECT_THAT(error_of({cloud, "--home", home, "-o", path("x.cloud"), "--voxel", voxel}),
                  HasSubstr("--voxel must be 0.001 to 1 m"));
    }
  }
  EXPECT_THAT(error_of({"glb", "--home", home, "-o", "/dev/full"}), HasSubstr("/dev/full"));
}

TEST_F(HomeCommandsTest, MapWritesTheTrajectoryThatExportWrites) {
  result_of({"map", path("walk"), "--no-networks", "--home", path("again.home"), "--trajectory",
             path("a.txt"), "--threads", "1"});
  result_of({"export", "tum", "--home", path("again.home"), "-o", path("b.txt")});
  EXPECT_EQ(read_text_file(path("a.txt")).value(), read_text_file(path("b.txt")).value());
  const auto digest = [](const std::string& home) {
    return result_of({"info", home, "--digest"}).at("content_sha256");
  };
  EXPECT_EQ(digest(path("again.home")), digest(path("my.home"))) << "at another number of threads";
}

TEST_F(HomeCommandsTest, WhereSomebodyLivesIsNobodysBusiness) {
  EXPECT_OK(testing::write_made_up_recording(path("told"), kFrames));
  const std::string picture = path("told/rgb/") + first_file("told/rgb");
  // As a phone that was held upside down stores it.
  const image::ColorImage stored = image::apply_orientation(image::read_color(picture).value(), 3);
  const Bytes jpeg =
      image::testing::with_exif(image::encode_jpeg(stored, 95), image::testing::exif_with_place(3));
  EXPECT_OK(write_file(picture, jpeg));
  const std::vector<std::string> map{"map", path("told"), "--no-networks", "--home",
                                     path("told.home")};
  const json all{"place", "device", "owner"};
  const json mapped = result_of(map);
  EXPECT_EQ(mapped.at("placed"), kFrames);
  EXPECT_EQ(mapped.at("left_out"), all);
  EXPECT_EQ(mapped_.at("left_out"), json::array());
  EXPECT_EQ(image::testing::secrets_in(read_file(path("told.home")).value()), "");
  EXPECT_EQ(image::testing::secrets_in(jpeg), "device owner place ") << "they were there";
  const home::Home home = home::Home::open_read_only(path("told.home")).value();
  EXPECT_EQ(image::decode_color(home.images(0)->color).value(), image::decode_color(jpeg).value());
  EXPECT_EQ(result_of({"info", path("told")}).at("left_out"), all);
  EXPECT_EQ(result_of({"record", "--source", path("told"), "-o", path("told-copy")}).at("left_out"),
            all);
  EXPECT_EQ(image::testing::secrets_in(
                read_file(path("told-copy/rgb/") + first_file("told-copy/rgb")).value()),
            "");
  EXPECT_FALSE(result_of({"info", path("told-copy")}).contains("left_out"));
  const ProgramResult told = run_roomwise({"info", path("told")});
  EXPECT_THAT(told.output,
              HasSubstr("where it was recorded (GPS), the device's name, whose it is"));
}

TEST_F(HomeCommandsTest, OneDamagedPictureDoesNotCostTheMap) {
  EXPECT_OK(testing::write_made_up_recording(path("damaged"), kFrames));
  const std::string picture = path("damaged/rgb/") + first_file("damaged/rgb");
  EXPECT_OK(write_file(picture, std::string_view("no picture")));
  std::vector<std::string> map{"map", path("damaged"), "--no-networks", "--home",
                               path("damaged.home")};
  const ProgramResult stopped = run_roomwise(map);
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_THAT(stopped.errors, HasSubstr(picture));
  EXPECT_THAT(stopped.errors, HasSubstr("--skip-damaged"));
  map.emplace_back("--skip-damaged");
  const json mapped = result_of(map);
  EXPECT_EQ(mapped.at("placed"), kFrames - 1);
  const json copied =
      result_of({"record", "--source", path("damaged"), "-o", path("whole"), "--skip-damaged"});
  EXPECT_EQ(copied.at("frames"), kFrames - 1);
  EXPECT_THAT(copied.at("damaged").at(0).get<std::string>(), HasSubstr(picture));
  EXPECT_THAT(mapped.at("damaged").at(0).get<std::string>(), HasSubstr(picture));
}

TEST_F(HomeCommandsTest, OneDamagedPictureOfTheMapDoesNotCostAFurtherWalk) {
  const std::string home = path("one_lost.home");
  std::filesystem::copy_file(path("my.home"), home);
  EXPECT_OK(home::Home::open(home)->database().run(
      "UPDATE keyframe_images SET color = x'00' WHERE keyframe_id = 0"));
  std::filesystem::copy(path("walk"), path("as_before"), std::filesystem::copy_options::recursive);
  std::vector<std::string> map{"map", path("as_before"), "--no-networks", "--home", home};
  const ProgramResult stopped = run_roomwise(map);
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_THAT(stopped.errors, HasSubstr("one_lost.home: key-frame 0: "));
  EXPECT_THAT(stopped.errors, HasSubstr("--skip-damaged"));
  map.emplace_back("--skip-damaged");
  const json mapped = result_of(map);
  EXPECT_EQ(mapped.at("frames"), kFrames);
  EXPECT_EQ(mapped.at("joined"), true);
  ASSERT_EQ(mapped.at("lost_pictures").size(), 1U);
  EXPECT_THAT(mapped.at("lost_pictures").at(0).get<std::string>(), HasSubstr("key-frame 0: "));
}

TEST_F(HomeCommandsTest, ACameraThatCannotBeIsRefused) {
  EXPECT_OK(testing::write_made_up_recording(path("odd"), 2));
  const std::vector<std::string> map{"map", path("odd"), "--no-networks", "--home",
                                     path("odd.home")};
  for (const char* camera : {"1e300 300 160 120 320 240 5000", "5 300 160 120 320 240 5000",
                             "300 300 99999 120 320 240 5000", "300 300 160 120 320 240 1e-6"}) {
    EXPECT_OK(write_file(path("odd/camera.txt"), std::string_view(camera)));
    const ProgramResult refused = run_roomwise(map);
    EXPECT_EQ(refused.exit_code, 1) << camera;
    EXPECT_THAT(refused.errors, HasSubstr("odd/camera.txt:1")) << camera;
  }
  EXPECT_OK(write_file(path("odd/camera.txt"), std::string_view("900 900 160 120 320 240 5000")));
  EXPECT_THAT(run_roomwise(map).errors, HasSubstr("may be wrong: a focal length of 900 px"));
}

TEST_F(HomeCommandsTest, AnyProcessorMakesTheSameMap) {
  const auto map_with = [&](const char* instructions, const std::string& home) {
    ::setenv("ROOMWISE_SIMD", instructions, 1);
    const ProgramResult result =
        run_roomwise({"map", path("walk"), "--no-networks", "--home", home});
    ::unsetenv("ROOMWISE_SIMD");
    return result;
  };
  EXPECT_EQ(map_with("portable", path("portable.home")).exit_code, 0);
  EXPECT_EQ(result_of({"info", path("portable.home"), "--digest"}).at("content_sha256"),
            result_of({"info", path("my.home"), "--digest"}).at("content_sha256"));
  const ProgramResult refused = map_with("mmx", path("refused.home"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("ROOMWISE_SIMD is 'mmx'"));
}

TEST_F(HomeCommandsTest, OptimizeLeavesAnOptimisedHomeWhereItIs) {
  std::filesystem::copy_file(path("my.home"), path("optimised.home"));
  const json optimised = result_of({"optimize", "--home", path("optimised.home")});
  EXPECT_EQ(optimised.at("poses"), mapped_.at("keyframes"));
  EXPECT_EQ(optimised.at("f_after"), mapped_.at("f_after"));
  // F is the pose graph's; the bundle ends a little above its minimum, and there again.
  EXPECT_GT(optimised.at("f_before").get<double>(), mapped_.at("f_after").get<double>());
  EXPECT_GT(mapped_.at("landmarks"), 0);
  EXPECT_EQ(optimised.at("landmarks"), mapped_.at("landmarks"));
  const auto digest = [](const std::string& home) {
    return result_of({"info", home, "--digest"}).at("content_sha256");
  };
  EXPECT_EQ(digest(path("optimised.home")), digest(path("my.home")));

  const json graph = result_of({"map", path("walk"), "--no-networks", "--home", path("graph.home"),
                                "--no-bundle-adjustment"});
  EXPECT_EQ(graph.at("landmarks"), 0);
  const json again = result_of({"optimize", "--home", path("graph.home")});
  EXPECT_FALSE(again.contains("landmarks"));
  EXPECT_NEAR(again.at("f_before").get<double>(), graph.at("f_after").get<double>(), 1e-6);
  EXPECT_EQ(run_roomwise({"optimize", "--home", path("absent.home")}).exit_code, 1);
  EXPECT_EQ(
      run_roomwise({"optimize", "--home", path("my.home"), "in.g2o", "-o", "out.g2o"}).exit_code,
      2);
}

TEST_F(HomeCommandsTest, OptimizeHoldsNothingUprightWhereItIsToldSo) {
  std::filesystem::copy_file(path("my.home"), path("once.home"));
  result_of({"map", path("walk"), "--no-networks", "--home", path("bent.home"), "--no-upright"});
  const auto is_upright = [&](const std::string& home, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"optimize", "--home", path(home)});
    return result_of(more).at("upright").get<bool>();
  };
  EXPECT_TRUE(is_upright("once.home"));
  EXPECT_FALSE(is_upright("once.home", {"--no-upright"}));
  EXPECT_TRUE(is_upright("once.home")) << "that was for once";
  EXPECT_FALSE(is_upright("bent.home")) << "it was mapped so";
  EXPECT_EQ(run_roomwise({"optimize", "in.g2o", "-o", "out.g2o", "--no-upright"}).exit_code, 2)
      << "a pose graph alone has no surfaces";
}

TEST_F(HomeCommandsTest, ReportShowsTheHomeOnOnePage) {
  result_of(
      {"report", path("my.home"), "-o", path("my.html"), "--truth", path("walk/groundtruth.txt")});
  const std::string page = read_text_file(path("my.html")).value();
  EXPECT_THAT(page, HasSubstr("<!DOCTYPE html>"));
  EXPECT_THAT(page, HasSubstr("hall"));
  EXPECT_THAT(page, HasSubstr("kitchen"));
  for (const char* outside : {"src=\"http", "href=\"http", "src=\"/"}) {
    EXPECT_THAT(page, Not(HasSubstr(outside))) << "the page needs nothing else";
  }
}

TEST_F(HomeCommandsTest, LocateSaysWhereAPictureWasTaken) {
  const std::string picture = path("walk/rgb/") + first_file("walk/rgb");
  const std::string depth = path("walk/depth/") + first_file("walk/depth");
  const json found = result_of(
      {"locate", "--home", path("my.home"), picture, picture, "--depth", depth, "--depth", depth});
  EXPECT_EQ(found.at("found"), true);
  // The map's world is the first key-frame's camera.
  for (const json& coordinate : found.at("position_m")) {
    EXPECT_NEAR(coordinate.get<double>(), 0, 0.01);
  }
  EXPECT_LT(found.at("position_sigma_m").get<double>(), 0.05);
  EXPECT_EQ(found.at("room"), "hall");
  EXPECT_EQ(result_of({"locate", "--home", path("my.home"), picture}).at("room"), "hall");

  const ProgramResult uneven =
      run_roomwise({"locate", "--home", path("my.home"), picture, picture, "--depth", depth});
  EXPECT_EQ(uneven.exit_code, 1);
  EXPECT_THAT(uneven.errors, HasSubstr("a depth image for every picture or none"));
  const ProgramResult other_camera =
      run_roomwise({"locate", "--home", path("my.home"), picture, "--camera", "fr1"});
  EXPECT_EQ(other_camera.exit_code, 1);
  EXPECT_THAT(other_camera.errors, HasSubstr("the camera takes 640x480"));
  EXPECT_EQ(run_roomwise({"locate", "--home", path("absent.home"), picture}).exit_code, 1);
}

// The walk shows a flat wall, of which a picture tells nothing of the focal length: the same from
// nearer by is the same.
TEST_F(HomeCommandsTest, LocateSaysWhenAnUnknownCameraLeavesThePlaceOpen) {
  const std::string picture = path("walk/rgb/") + first_file("walk/rgb");
  const std::string depth = path("walk/depth/") + first_file("walk/depth");
  const std::vector<std::string> command{"locate", "--home",   path("my.home"),
                                         picture,  "--camera", "unknown"};
  const json vague = result_of(command);
  EXPECT_EQ(vague.at("found"), false);
  EXPECT_EQ(vague.at("status"), "the pose is not known well enough");
  EXPECT_GT(vague.at("focal_length_sigma").get<double>(), 0.05);

  std::vector<std::string> with_depth = command;
  with_depth.insert(with_depth.end(), {"--depth", depth});
  EXPECT_THAT(run_roomwise(with_depth).errors, HasSubstr("--depth needs a camera that is known"));
}

// What the flat wall does not tell, the photo's own words do.
TEST_F(HomeCommandsTest, LocateTakesAPhotosWordForItsFocalLength) {
  const auto color = image::read_color(path("walk/rgb/") + first_file("walk/rgb"));
  ASSERT_OK(color);
  const auto photo_of = [&](std::uint32_t focal_35mm_mm) {
    const Bytes exif = image::testing::ExifWriter(true).write({{0xA405, 3, focal_35mm_mm}});
    EXPECT_OK(write_file(path("photo.jpg"),
                         image::testing::with_exif(image::encode_jpeg(*color, 95), exif)));
    return result_of(
        {"locate", "--home", path("my.home"), path("photo.jpg"), "--camera", "unknown"});
  };
  // 300 px of 320, between 36 and 34.6 mm of the longer side.
  const json told = photo_of(33);
  EXPECT_NEAR(told.at("focal_length").get<double>(), 300.0 / 320, 0.05);
  EXPECT_LT(told.at("focal_length_sigma").get<double>(), 0.05);
  // And of another lens that it does not have, so that the same picture is taken from elsewhere.
  EXPECT_NEAR(photo_of(28).at("focal_length").get<double>(), 0.8, 0.05);
}

TEST_F(HomeCommandsTest, EvalLocalizerAsksForTheFramesOfAVisit) {
  // As if the walk were walked again.
  const std::vector<std::string> command{"eval",    "localizer",  "--home",  path("my.home"),
                                         "--truth", path("walk"), "--visit", path("walk")};
  const json every = result_of(command);
  EXPECT_EQ(every.at("questions"), kFrames);
  EXPECT_EQ(every.at("near"), 1);
  EXPECT_EQ(every.at("wrong"), 0);
  EXPECT_LT(every.at("median_error_m").get<double>(), 0.01);
  auto fewer = command;
  fewer.insert(fewer.end(), {"--every", "4", "--without-depth"});
  EXPECT_EQ(result_of(fewer).at("questions"), kFrames / 4);
  auto pairs = command;
  pairs.insert(pairs.end(), {"--pairs", "--near", "1e-9"});
  const json strict = result_of(pairs);
  EXPECT_EQ(strict.at("questions"), kFrames - 1) << "the first has none before it";
  EXPECT_EQ(strict.at("near"), 0);
  EXPECT_EQ(strict.at("further_off"), 1);
}

// A walk along the other half of the wall and beyond.
TEST_F(HomeCommandsTest, AFurtherWalkJoinsTheMapAndCanBeTakenOut) {
  ASSERT_OK(testing::write_made_up_recording(path("later"), kFrames, 12));
  const std::string home = path("grown.home");
  std::filesystem::copy(path("my.home"), home);
  const std::vector<std::string> map{"map", path("later"), "--no-networks", "--home", home};
  const json grown = result_of(map);
  EXPECT_EQ(grown.at("walks"), 2);
  EXPECT_EQ(grown.at("joined"), true);
  EXPECT_EQ(grown.at("pieces"), 1);
  const json recordings = result_of({"info", home, "--verify"}).at("recordings");
  ASSERT_EQ(recordings.size(), 2U);
  for (const json& one : recordings) {
    EXPECT_EQ(one.at("frames"), kFrames);
    EXPECT_EQ(one.at("placed"), kFrames);
    EXPECT_EQ(one.at("component"), 0);
  }
  EXPECT_EQ(recordings[0].at("name"), "walk");
  EXPECT_EQ(recordings[1].at("name"), "later");

  result_of({"export", "tum", "--home", home, "--walk", "later", "-o", path("later.txt")});
  EXPECT_LT(
      result_of({"eval", "trajectory", "--truth", path("later"), "--estimate", path("later.txt")})
          .at("ate_rmse_m")
          .get<double>(),
      0.01);

  const auto error_of = [](const std::vector<std::string>& command) {
    const ProgramResult refused = run_roomwise(command);
    EXPECT_EQ(refused.exit_code, 1);
    return refused.errors;
  };
  EXPECT_THAT(error_of(map), HasSubstr("holds this recording already, as later"));
  EXPECT_THAT(error_of({"map", path("later"), "--home", home, "--features", "orb"}),
              HasSubstr("leave out --features"));
  EXPECT_THAT(error_of({"map", path("later"), "--home", home, "--resume"}),
              HasSubstr("is finished"));
  EXPECT_THAT(error_of({"forget", "sunday", "--home", home}),
              HasSubstr("give one of walk (#1), later (#2)"));
  // As the commands call it that tell of two walks of one name.
  const auto floor_made_from = [&] {
    return home::Home::open(home)->derived_data("floor").value()->made_from;
  };
  const std::string of_both = floor_made_from();
  const json left = result_of({"forget", "walk (#1)", "--home", home});
  EXPECT_NE(floor_made_from(), of_both) << "no later command has to find it anew";
  EXPECT_EQ(left.at("walks"), 1);
  EXPECT_EQ(result_of({"info", home, "--verify"}).at("recordings")[0].at("name"), "later");
}

TEST_F(HomeCommandsTest, AForgottenWalkGoesWithItsFolderWhereThatIsTheHomes) {
  const std::string home = path("served.home"), own = path("served.home.walks/later");
  std::filesystem::copy(path("my.home"), home);
  std::filesystem::create_directories(path("served.home.walks"));
  ASSERT_OK(testing::write_made_up_recording(own, kFrames, 12));
  result_of({"map", own, "--no-networks", "--home", home});
  result_of({"forget", "later", "--home", home});
  EXPECT_FALSE(std::filesystem::exists(own)) << "else serve would map it again";
  result_of({"forget", "walk", "--home", home});
  EXPECT_TRUE(std::filesystem::exists(path("walk"))) << "that recording is not the home's";
}

TEST_F(HomeCommandsTest, NoCommandWritesOverAHome) {
  const std::string before = result_of({"info", path("my.home"), "--digest"}).dump();
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"export", "ply", "--home", path("my.home"), "-o", path("my.home")},
           {"export", "glb", "--home", path("my.home"), "-o", path("my.home")},
           {"report", path("my.home"), "-o", path("my.home")},
           {"info", path("walk"), "--json-file", path("my.home")}}) {
    const ProgramResult refused = run_roomwise(command);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.errors, HasSubstr("not overwritten"));
  }
  EXPECT_EQ(result_of({"info", path("my.home"), "--digest"}).dump(), before);
}

TEST_F(HomeCommandsTest, AMistakeAtTheFirstTryLeavesNoHome) {
  // The pictures are smaller than this camera's.
  const ProgramResult wrong = run_roomwise(
      {"map", path("walk"), "--no-networks", "--home", path("tried.home"), "--camera", "fr1"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(path("tried.home")));
}

TEST_F(HomeCommandsTest, InfoSaysWhatAFileIs) {
  const json home = result_of({"info", path("my.home"), "--digest", "--verify"});
  EXPECT_EQ(home.at("kind"), "home");
  EXPECT_EQ(home.at("frames"), kFrames);
  EXPECT_EQ(home.at("keyframes"), mapped_.at("keyframes"));
  EXPECT_EQ(home.at("content_sha256").get<std::string>().size(), 64U);
  const json walk = result_of({"info", path("walk")});
  EXPECT_EQ(walk.at("kind"), "recording");
  EXPECT_EQ(walk.at("frames"), kFrames);
  EXPECT_EQ(walk.at("rooms"), "hall, kitchen");
  ASSERT_OK(write_file(path("notes.txt"), "buy milk"));
  const ProgramResult unknown = run_roomwise({"info", path("notes.txt")});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.errors, HasSubstr("notes.txt"));
}

TEST_F(HomeCommandsTest, ConceptsAreEdited) {
  std::filesystem::copy_file(path("my.home"), path("concepts.home"));
  const std::string home = path("concepts.home");
  json concepts = result_of({"concepts", "add", "--home", home, "--object", "piano", "--label",
                             "upright", "--label", "grand piano", "--room-type", "music room"});
  EXPECT_EQ(concepts.at("objects").at("piano"), json({"grand piano", "upright"}));
  EXPECT_EQ(concepts.at("room_types").at("music room"), json({"piano"}));

  concepts = result_of(
      {"concepts", "remove", "--home", home, "--object", "piano", "--room-type", "music room"});
  EXPECT_TRUE(concepts.at("objects").contains("piano"));
  EXPECT_EQ(concepts.at("room_types").at("music room"), json::array());
  result_of({"concepts", "remove", "--home", home, "--object", "piano", "--label", "upright"});
  concepts = result_of({"concepts", "list", "--home", home});
  EXPECT_EQ(concepts.at("objects").at("piano"), json({"grand piano"}));
  result_of({"concepts", "remove", "--home", home, "--object", "piano"});
  result_of({"concepts", "remove", "--home", home, "--room-type", "music room"});
  EXPECT_EQ(result_of({"concepts", "list", "--home", home}), result_of({"concepts", "list"}));

  EXPECT_EQ(run_roomwise({"concepts", "remove", "--home", home, "--object", "unicorn"}).exit_code,
            1);
  EXPECT_EQ(run_roomwise({"concepts", "add", "--home", home}).exit_code, 2);
}

TEST_F(HomeCommandsTest, ObjectsOfAHomeWithoutANetworkAreNone) {
  EXPECT_EQ(result_of({"objects", "list", "--home", path("my.home")}),
            json({{"rule", "regions"}, {"objects", json::array()}}));
}

TEST_F(HomeCommandsTest, RecordCopiesARecordingWithItsRoomsAndTruth) {
  const json recorded = result_of(
      {"record", "--source", path("walk"), "-o", path("copy"), "--frames", "20", "--threads", "1"});
  EXPECT_EQ(recorded.at("frames"), 20);
  const auto text = [](const std::string& file) { return read_text_file(file).value(); };
  EXPECT_EQ(text(path("copy/groundtruth.txt")), text(path("walk/groundtruth.txt")));
  EXPECT_THAT(text(path("copy/rooms.txt")), HasSubstr("0 11 hall 1\n12 19 kitchen 1\n"));
  const json copied = result_of({"info", path("copy")});
  EXPECT_EQ(copied.at("frames"), 20);
}

TEST_F(HomeCommandsTest, RecordNamesTheRoomItStartsIn) {
  result_of({"record", "--source", path("walk"), "-o", path("named"), "--room", "my room",
             "--seconds", "0.5"});
  EXPECT_THAT(read_text_file(path("named/rooms.txt")).value(), HasSubstr("my room"));
  EXPECT_EQ(result_of({"info", path("named")}).at("frames"), 6);
}

TEST_F(HomeCommandsTest, RecordLeavesNoFolderWhereTheCommandIsWrong) {
  const std::vector<std::string> record{"record", "--source", path("walk"), "-o", path("wrong")};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = record;
    command.insert(command.end(), more.begin(), more.end());
    return run_roomwise(command);
  };
  EXPECT_EQ(with({"--room", "a  b"}).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(path("wrong")));
  EXPECT_EQ(with({"--frames", "0"}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(path("wrong")));
  EXPECT_EQ(with({"--room", "a b", "--frames", "1"}).exit_code, 0);
}

TEST_F(HomeCommandsTest, NumbersThatCountAreNotNegative) {
  const std::string home = path("my.home");
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"locate", path("walk"), "--home", home, "--frame", "-1"},
           {"rooms", "eval", "--recording", path("walk"), "--home", home, "--margin", "-1"},
           {"rooms", "eval", "--recording", path("walk"), "--home", home, "--pair-step", "-1"},
           {"rooms", "eval", "--recording", path("walk"), "--home", home, "--max-voted", "-1"},
           {"map", path("walk"), "--home", home, "--working-set", "-1"}}) {
    const ProgramResult result = run_roomwise(command);
    EXPECT_EQ(result.exit_code, 2) << command.back();
    EXPECT_THAT(result.errors, HasSubstr("-1 must not be negative")) << command.end()[-2];
  }
}

TEST_F(HomeCommandsTest, JsonFileHoldsTheSameAsJson) {
  const ProgramResult result =
      run_roomwise({"info", path("walk"), "--json", "--json-file", path("info.json")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(read_text_file(path("info.json")).value(), result.output);
}

}  // namespace
}  // namespace roomwise
