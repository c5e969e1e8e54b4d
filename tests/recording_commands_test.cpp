// Every kind of recording that is read, given to every command that takes one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "every_kind.h"
#include "made_up_detector.h"
#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/recording/open_recording.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::ScratchFolder;

// A home that was mapped and whose rooms were learned, and the beginning of its walk.
class RecordingCommandsTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 8;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::write_made_up_recording(path("mapped"), 24));
    EXPECT_OK(testing::write_made_up_recording(path("walk"), kFrames));
    EXPECT_OK(testing::write_detector_of_the_middle(path("data/roomwise/networks")));
    EXPECT_OK(write_file(path("colors.onnx"), testing::mean_color_network()));
    EXPECT_OK(write_file(path("colors.card.json"), R"({"input": {"width": 6, "height": 4}})"));
    result_of({"map", path("mapped"), "--home", path("my.home"), "--network", path("colors.onnx"),
               "--keyframe-translation", "0.02"});
    result_of({"rooms", "learn", "--home", path("my.home"), "--network", path("colors.onnx")});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }
  static json result_of(const std::vector<std::string>& arguments) {
    return testing::result_of(arguments, path("data"));
  }
  // What is said of what a command refuses: one line, whatever was noted before.
  static std::string refusal_of(const std::vector<std::string>& arguments) {
    const ProgramResult result = testing::run_roomwise(arguments, path("data"));
    EXPECT_EQ(result.exit_code, 1) << fmt::format("{}", fmt::join(arguments, " "));
    const std::size_t at = result.errors.rfind("roomwise: ");
    if (at == std::string::npos) return result.errors;
    EXPECT_EQ(result.errors.find('\n', at), result.errors.size() - 1) << result.errors;
    return result.errors.substr(at);
  }
  // Every command that takes a recording, as it is given one; what it makes is called `made`.
  static std::map<std::string, std::vector<std::string>> commands_with(const std::string& recording,
                                                                       const std::string& made) {
    const std::string home = path("my.home"), network = path("colors.onnx");
    return {{"info", {"info", recording}},
            {"record", {"record", "--source", recording, "-o", path(made)}},
            {"map", {"map", recording, "--home", path(made + ".home"), "--no-networks"}},
            {"update", {"update", "--home", home, "--dry-run", "--without-rooms", recording}},
            {"rooms eval",
             {"rooms", "eval", "--home", home, "--network", network, "--recording", recording,
              "--labels", path("walk/rooms.txt")}},
            {"locate", {"locate", "--home", home, recording, "--frame", "5"}}};
  }

  inline static std::unique_ptr<ScratchFolder> folder_;
};

TEST_F(RecordingCommandsTest, TakeEveryKind) {
  int count = 0;
  for (const recording::RecordingKind& kind : recording::recording_kinds()) {
    SCOPED_TRACE(std::string(kind.name));
    const std::string made = fmt::format("kind-{}", ++count);
    const auto recording = testing::write_as_kind(kind.name, path("walk"), path(made));
    ASSERT_OK(recording);
    auto commands = commands_with(*recording, made + "-copy");
    const json info = result_of(commands["info"]);
    EXPECT_EQ(info.at("kind"), "recording");
    EXPECT_EQ(info.at("frames"), kFrames);
    EXPECT_EQ(result_of(commands["record"]).at("frames"), kFrames);
    EXPECT_EQ(result_of({"info", path(made + "-copy")}).at("frames"), kFrames);
    EXPECT_EQ(result_of(commands["map"]).at("placed"), kFrames);
    EXPECT_EQ(result_of(commands["update"]).at("frames"), kFrames);
    EXPECT_EQ(result_of(commands["rooms eval"]).at("single").at("n"), kFrames);
    const json place = result_of(commands["locate"]);
    ASSERT_TRUE(place.at("found")) << place;
    EXPECT_NEAR(place.at("position_m")[0].get<double>(), 5 * 3 * 2.0 / 300, 0.02);
  }
}

TEST_F(RecordingCommandsTest, SayWhatTheyReadOfWhatIsNone) {
  std::filesystem::create_directories(path("empty"));
  auto commands = commands_with(path("empty"), "none");
  commands.erase("locate");  // takes pictures, too
  for (const auto& [name, command] : commands) {
    EXPECT_THAT(refusal_of(command), HasSubstr("is no recording of a kind that is read")) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(path("none")));
  EXPECT_FALSE(std::filesystem::exists(path("none.home")));
  EXPECT_THAT(refusal_of({"locate", "--home", path("my.home"), path("empty"), "--frame", "5"}),
              HasSubstr("empty: is no recording"));
}

TEST_F(RecordingCommandsTest, SayWhatIsToBeGivenBesides) {
  const auto file = testing::write_as_kind("MCAP", path("walk"), path("alone"));
  ASSERT_OK(file);
  const std::string home = path("my.home");
  EXPECT_THAT(refusal_of({"rooms", "eval", "--home", home, "--network", path("colors.onnx"),
                          "--recording", *file}),
              HasSubstr("walk.mcap: has no rooms.txt that says which rooms it shows; give one by "
                        "--labels"));
  EXPECT_THAT(
      refusal_of({"rooms", "eval", "--home", home, "--network", path("colors.onnx"), "--recording",
                  *file, "--recording", path("walk"), "--labels", path("walk/rooms.txt")}),
      HasSubstr("1 --labels and 2 --recording"));
  EXPECT_THAT(refusal_of({"locate", "--home", home, *file}),
              HasSubstr("walk.mcap: is a recording; say by --frame which of its pictures, 0 to 7"));
  EXPECT_THAT(refusal_of({"locate", "--home", home, *file, "--frame", "8"}),
              HasSubstr("has no frame 8 with depth"));
  EXPECT_THAT(refusal_of({"locate", "--home", home, *file, "--frame", "1", "--camera", "unknown"}),
              HasSubstr("leave --camera unknown out"));
  std::filesystem::copy(path("walk"), path("cameraless"), std::filesystem::copy_options::recursive);
  std::filesystem::remove(path("cameraless/camera.txt"));
  for (const char* name : {"map", "record", "update", "locate"}) {
    auto command = commands_with(path("cameraless"), "of-cameraless")[name];
    EXPECT_THAT(refusal_of(command), HasSubstr("give --camera")) << name;
    command.insert(command.end(), {"--camera", path("walk/camera.txt")});
    EXPECT_EQ(testing::run_roomwise(command, path("data")).exit_code, 0) << name;
  }
}

// A picture that is no picture any more, told before any work or by reading it, and its camera's
// file, where it has one.
TEST_F(RecordingCommandsTest, SayHowToGoOnWithoutDamageAndDo) {
  const std::vector<std::pair<std::string, std::string>> damages{
      {"3D Scanner App, All Data", "frame_00003.jpg"},
      {"3D Scanner App, All Data", "frame_00007.json"},
      {"Polycam, raw data", "keyframes/depth/400000.png"},
      {"Record3D, EXR and JPG", "rgb/3.jpg"}};
  int count = 0;
  for (const auto& [kind, file] : damages) {
    SCOPED_TRACE(file);
    const std::string made = fmt::format("damaged-{}", ++count);
    const auto recording = testing::write_as_kind(kind, path("walk"), path(made));
    ASSERT_OK(recording);
    ASSERT_TRUE(std::filesystem::exists(*recording / file));
    EXPECT_OK(write_file(*recording / file, std::string_view("no more")));
    auto commands = commands_with(*recording, made + "-copy");
    for (const char* name : {"record", "map", "update", "rooms eval"}) {
      std::vector<std::string> command = commands[name];
      EXPECT_THAT(refusal_of(command),
                  ::testing::AllOf(HasSubstr(std::filesystem::path(file).stem().string()),
                                   HasSubstr("give --skip-damaged")))
          << name;
      std::filesystem::remove_all(path(made + "-copy"));
      std::filesystem::remove(path(made + "-copy.home"));
      command.emplace_back("--skip-damaged");
      const json result = result_of(command);
      ASSERT_EQ(result.at("damaged").size(), 1U) << name;
      EXPECT_THAT(result.at("damaged")[0].get<std::string>(),
                  HasSubstr(std::filesystem::path(file).stem().string()));
      const json& all =
          name == std::string("rooms eval") ? result.at("single").at("n") : result.at("frames");
      EXPECT_EQ(all, kFrames - 1) << name;
    }
  }
}

// KinectFusion's poses are no motion of the device's, but the truth of 7-Scenes.
TEST_F(RecordingCommandsTest, ACopyKeepsTheTruthOfItsKind) {
  const auto scenes = testing::write_as_kind("7-Scenes", path("walk"), path("scenes"));
  ASSERT_OK(scenes);
  result_of({"record", "--source", *scenes, "-o", path("scenes-copy")});
  EXPECT_EQ(recording::read_truth(path("scenes-copy"))->size(), std::size_t{kFrames});
  EXPECT_FALSE(std::filesystem::exists(path("scenes-copy/odometry.txt")));
}

}  // namespace
}  // namespace roomwise
