// A simulated walk, its map, and the map against the truth, command by command.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;

// Two walks through one very small home, the first of which is mapped; all tests look at them.
class SimulatedTruth : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(write_file(path("camera.txt"), "132 132 79.5 59.5 160 120 5000\n"));
    simulate("walk", "1");
    simulate("other", "2");
    result_of({"map", path("walk"), "--home", path("my.home"), "--no-networks"});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }
  static void simulate(const std::string& name, const std::string& walk_seed) {
    result_of({"simulate",
               "--home-seed",
               "3",
               "--rooms",
               "toilet",
               "--walk-seed",
               walk_seed,
               "--fps",
               "4",
               "--frames",
               "12",
               "--no-fast-turns",
               "--camera",
               path("camera.txt"),
               "--samples",
               "1",
               "--bake-effort",
               "0.02",
               "--without",
               "motion-blur",
               "-o",
               path(name)});
  }
  static std::string error_of(const std::vector<std::string>& command) {
    const ProgramResult result = run_roomwise(command);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    return result.errors;
  }

 private:
  static inline std::unique_ptr<ScratchFolder> folder_;
};

TEST_F(SimulatedTruth, ExactDepthAtTruePosesLiesOnTheSurfaces) {
  for (const char* surface : {"cloud", "mesh"}) {
    const std::vector<std::string> command{"eval",    "map",        "--home",    path("my.home"),
                                           "--truth", path("walk"), "--surface", surface};
    std::vector<std::string> at_true_poses = command;
    at_true_poses.emplace_back("--true-poses");
    const json exact = result_of(at_true_poses), as_mapped = result_of(command);
    EXPECT_GT(exact.at("points"), 1000) << surface;
    EXPECT_LT(exact.at("median_m"), 0.005) << surface;
    EXPECT_GT(exact.at("within_1cm"), 0.75) << surface;
    EXPECT_GT(as_mapped.at("points"), 1000) << surface;
    EXPECT_GT(as_mapped.at("rmse_m"), exact.at("rmse_m")) << surface;
  }
}

TEST_F(SimulatedTruth, ThingsThatNobodyNamedAreMissed) {
  const json objects = result_of({"eval", "objects", "--home", path("my.home"), "--truth",
                                  path("walk"), "--report", path("objects.html")});
  const std::string missed = objects.at("instances").at("missed").dump();
  EXPECT_THAT(read_text_file(path("objects.html")).value(),
              HasSubstr("Missed, joined from regions: " + missed));
  for (const char* way : {"instances", "naive", "rules", "ours", "paper"}) {
    EXPECT_EQ(objects.at(way).at("found"), 0) << "there was no network";
    EXPECT_EQ(objects.at(way).at("false"), 0);
    EXPECT_EQ(objects.at(way).at("missed"), objects.at("instances").at("missed"));
  }
  EXPECT_TRUE(objects.at("instances").at("from_middle_m").at("median").is_null())
      << "what was not found is not without an error";
  EXPECT_TRUE(objects.at("instances").at("within_one_sigma").is_null());
}

// The walk is too short to leave the hall, or to see much of its floor.
TEST_F(SimulatedTruth, TheRoomThatWasWalkedLiesOnTheFloor) {
  const json layout =
      result_of({"rooms", "layout", "--home", path("my.home"), "--plan", path("plan.svg")});
  ASSERT_EQ(layout.at("rooms").size(), 1U);
  EXPECT_EQ(layout.at("rooms").at(0).at("name"), "hall");
  EXPECT_GT(layout.at("rooms").at(0).at("floor_m2"), 0.1);
  EXPECT_TRUE(layout.at("doorways").empty());
  EXPECT_THAT(read_text_file(path("plan.svg")).value(), HasSubstr(">hall<"));
  const json truth =
      result_of({"eval", "layout", "--home", path("my.home"), "--truth", path("walk")});
  EXPECT_EQ(truth.at("doors"), 0) << "of doors between named rooms";
  EXPECT_EQ(truth.at("false_doorways"), 0);
  EXPECT_TRUE(truth.at("door_error_median_m").is_null());
  EXPECT_GE(truth.at("floor_m2"), truth.at("right_floor_m2"));
}

TEST_F(SimulatedTruth, AnotherRecordingIsNoTruth) {
  for (const char* what : {"map", "objects", "floor", "layout"}) {
    EXPECT_THAT(error_of({"eval", what, "--home", path("my.home"), "--truth", path("other")}),
                HasSubstr("was not mapped from"))
        << what;
  }
}

TEST_F(SimulatedTruth, AHomeThatTheProgramNoLongerMakesIsNoTruth) {
  std::filesystem::copy(path("walk"), path("old"), std::filesystem::copy_options::recursive);
  json made = json::parse(read_text_file(path("old/simulation.json")).value());
  made["scene_sha256"] = std::string(64, '0');
  ASSERT_OK(write_file(path("old/simulation.json"), made.dump()));
  EXPECT_THAT(error_of({"eval", "map", "--home", path("my.home"), "--truth", path("old")}),
              HasSubstr("make the recording anew"));
  made.erase("scene_sha256");
  ASSERT_OK(write_file(path("old/simulation.json"), made.dump()));
  EXPECT_THAT(error_of({"eval", "map", "--home", path("my.home"), "--truth", path("old")}),
              HasSubstr("scene_sha256"));
}

}  // namespace
}  // namespace roomwise
