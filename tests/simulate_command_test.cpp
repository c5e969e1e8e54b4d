// A simulated home by command: recorded, looked at, kept.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(Simulate, RecordsAWalkAndKeepsIt) {
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "camera.txt", "66 66 39.5 29.5 80 60 5000\n"));
  const std::vector<std::string> command{"simulate",
                                         "--home-seed",
                                         "3",
                                         "--rooms",
                                         "toilet",
                                         "--scenario",
                                         "evening",
                                         "--fps",
                                         "1",
                                         "--frames",
                                         "3",
                                         "--camera",
                                         folder / "camera.txt",
                                         "--samples",
                                         "1",
                                         "--bake-effort",
                                         "0.02",
                                         "--keep",
                                         "-o",
                                         folder / "walk"};
  const json made = result_of(command);
  EXPECT_EQ(made.at("frames"), 3);
  EXPECT_EQ(made.at("rooms"), 2) << "a hall leads to it";
  const json info = result_of({"info", folder / "walk"});
  EXPECT_EQ(info.at("kind"), "recording");
  EXPECT_EQ(info.at("frames"), 3);
  EXPECT_EQ(info.at("ground_truth"), true);
  EXPECT_EQ(result_of(command).at("kept"), true);

  std::vector<std::string> other = command;
  other[6] = "night";
  const ProgramResult refused = run_roomwise(other);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("empty"));
}

TEST(SimulateViews, WritesPicturesToTrainBy) {
  const ScratchFolder folder;
  const std::vector<std::string> command{
      "simulate-views", "--homes", "3",       "3",      "--of-kind", "1",
      "--of-room",      "1",       "--side",  "40",     "--samples", "1",
      "--bake-effort",  "0.02",    "--rooms", "toilet", "-o",        folder / "views"};
  const json made = result_of(command);
  EXPECT_EQ(made.at("homes"), 1);
  EXPECT_GT(made.at("pictures"), 5);
  EXPECT_TRUE(std::filesystem::exists(folder / "views" / "toilet"));
  std::vector<std::string> backwards = command;
  backwards[3] = "2";
  EXPECT_THAT(run_roomwise(backwards).errors, HasSubstr("must not come after"));
}

TEST(Simulate, SaysWhatItDoesNotKnow) {
  const ScratchFolder folder;
  const auto error_of = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"simulate", "-o", folder / "walk"});
    const ProgramResult result = run_roomwise(more);
    EXPECT_EQ(result.exit_code, 1);
    return result.errors;
  };
  EXPECT_THAT(error_of({"--scenario", "dusk"}), HasSubstr("dusk"));
  EXPECT_THAT(error_of({"--rooms", "ballroom"}), HasSubstr("ballroom"));
  EXPECT_THAT(error_of({"--without", "colour"}), HasSubstr("motion-blur"));
  EXPECT_THAT(error_of({"--furniture", folder / "none"}), HasSubstr("sweethome3d-furniture"));
  EXPECT_THAT(error_of({"--rooms", "toilet", "--light-cache", folder / "none/flat.light"}),
              HasSubstr("none/flat.light"))
      << "before anything is baked";
  EXPECT_FALSE(std::filesystem::exists(folder / "walk"));
}

}  // namespace
}  // namespace roomwise
