// Training a network from the command line, with small pictures and a small network.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "run_program.h"

namespace roomwise {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::run_roomwise;
using testing::ScratchFolder;

class TrainCommandTest : public ::testing::Test {
 protected:
  TrainCommandTest() {
    EXPECT_OK(write_file(path("colors.onnx"), testing::mean_color_network()));
    EXPECT_OK(write_file(path("colors.card.json"), R"({"input": {"width": 6, "height": 4},
        "mean": [128, 128, 128], "scale": [0.02, 0.02, 0.02],
        "outputs": {"features": "means"}})"));
    const std::pair<const char*, Rgb8> rooms[] = {
        {"attic", {200, 60, 60}}, {"cellar", {60, 200, 60}}, {"garage", {60, 60, 200}}};
    for (const auto& [room, color] : rooms) {
      std::filesystem::create_directories(path(std::string("photos/") + room));
      for (int i = 0; i < 6; ++i) {
        const auto shade = static_cast<std::uint8_t>(color.b + 5 * i);
        const image::ColorImage photo(12, 8, {color.r, color.g, shade});
        EXPECT_OK(
            write_file(path(fmt::format("photos/{}/{}.png", room, i)), image::encode_png(photo)));
      }
    }
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }

  // With further arguments.
  [[nodiscard]] testing::ProgramResult train(const std::string& output,
                                             const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"train", path("photos"), "--network", path("colors.onnx"),
                                 "--out", path(output),   "--threads", "1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_roomwise(all);
  }

  ScratchFolder folder_;
};

#ifdef ROOMWISE_HAS_TRAINING

TEST_F(TrainCommandTest, MakesANetworkThatNamesTheClasses) {
  const auto result =
      train("out", {"--learning-rate", "1", "--steps", "60", "--batch", "6", "--name", "rooms",
                    "--no-augmentation", "--evaluate-every", "20", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto answer = nlohmann::json::parse(result.output);
  EXPECT_THAT(answer.at("classes"), ElementsAre("attic", "cellar", "garage"));
  EXPECT_EQ(answer.at("pictures"), 15);
  EXPECT_EQ(answer.at("held_out"), 3);
  ASSERT_EQ(answer.at("curve").size(), 3);
  EXPECT_EQ(answer.at("curve").back().at("held_out_precision"), 1);
  EXPECT_FALSE(std::filesystem::exists(path("out/rooms.checkpoint")));
  const auto page = read_text_file(path("out/rooms.training.html"));
  ASSERT_OK(page);
  EXPECT_THAT(*page, HasSubstr("Held-out precision against steps"));
  EXPECT_THAT(*page, HasSubstr("chosen on the held-out pictures themselves"));

  // It is used as any other network.
  const auto network = network::OnnxClassifier::load(path("out/rooms.onnx"));
  ASSERT_OK(network);
  EXPECT_THAT((*network)->labels(), ElementsAre("attic", "cellar", "garage"));
  EXPECT_EQ((*network)->feature_size(), 3);
  const auto seen = (*network)->predict(image::ColorImage(12, 8, {70, 190, 70}));
  ASSERT_OK(seen);
  EXPECT_GT(seen->scores[1], 0.5F);
}

TEST_F(TrainCommandTest, BeginsWithACompactNetworkOfRandomWeights) {
  std::filesystem::create_directories(path("other/cellar"));
  std::filesystem::create_directories(path("other/attic"));
  for (const char* room : {"cellar", "attic"}) {
    std::filesystem::copy(path(std::string("photos/") + room + "/1.png"),
                          path(std::string("other/") + room + "/1.png"));
  }
  const auto result = run_roomwise({"train", path("photos"), "--network", "compact", "--held-out",
                                    path("other"), "--steps", "2", "--batch", "2", "--threads", "1",
                                    "--out", path("out"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(nlohmann::json::parse(result.output).at("held_out"), 2) << "not of every class";
  const auto network = network::OnnxClassifier::load(path("out/roomwise-compact-trained.onnx"));
  ASSERT_OK(network);
  EXPECT_THAT((*network)->labels(), ElementsAre("attic", "cellar", "garage"));
  EXPECT_EQ((*network)->feature_size(), 256);
}

TEST_F(TrainCommandTest, WhatIsTrainedOnIsNotHeldOut) {
  std::filesystem::create_directory_symlink(path("photos"), path("same"));
  for (const char* same : {"photos", "photos/", "same"}) {
    const auto result = train("out", {"--held-out", path(same), "--steps", "1"});
    EXPECT_EQ(result.exit_code, 1) << same;
    EXPECT_THAT(result.errors, HasSubstr("is both to be trained on and held out"));
  }
}

TEST_F(TrainCommandTest, GoesOnWhereItStopped) {
  std::vector<std::string> options{
      "--batch",          "1", "--steps", "20", "--held-out-share", "0", "--checkpoint-every", "1",
      "--evaluate-every", "7"};
  ASSERT_EQ(train("whole", options).exit_code, 0);
  // A picture that cannot be read ends the training somewhere in its first epoch.
  const std::string picture = path("photos/cellar/3.png");
  const auto bytes = read_file(picture);
  ASSERT_OK(bytes);
  ASSERT_OK(write_file(picture, "torn"));
  const auto stopped = train("parts", options);
  EXPECT_EQ(stopped.exit_code, 1);
  EXPECT_THAT(stopped.errors, HasSubstr("cellar/3.png"));
  ASSERT_OK(write_file(picture, *bytes));
  EXPECT_THAT(train("parts", options).errors,
              HasSubstr("go on with --resume, or remove this file"));
  options.push_back("--resume");
  const auto resumed = train("parts", options);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(read_file(path("parts/colors-trained.onnx")).value(),
            read_file(path("whole/colors-trained.onnx")).value());
}

TEST_F(TrainCommandTest, LearnsTheRoomsOfAHome) {
  ASSERT_OK(testing::write_made_up_recording(path("walk"), 12));
  const std::string home = path("mapped.home");
  testing::result_of(
      {"map", path("walk"), "--home", home, "--keyframe-translation", "0.02", "--threads", "1"});
  testing::result_of({"rooms", "name", "--home", home, "--frames", "0-2=hall", "--frames",
                      "3-5=kitchen", "--frames", "6-8=hall", "--frames", "9-11=kitchen"});
  std::vector<std::string> command{
      "train",   "--home", home,      "--network", path("colors.onnx"), "--out", path("out"),
      "--steps", "2",      "--batch", "2",         "--threads",         "1"};
  const auto with = [&](const std::vector<std::string>& options) {
    std::vector<std::string> all = command;
    all.insert(all.end(), options.begin(), options.end());
    return all;
  };
  const auto all = testing::result_of(command);
  EXPECT_THAT(all.at("classes"), ElementsAre("hall", "kitchen"));
  EXPECT_EQ(all.at("held_out"), 0);
  // What is held out is not trained on.
  const auto answer = testing::result_of(with({"--held-out-visits", "2-"}));
  const int pictures = answer.at("pictures"), held_out = answer.at("held_out");
  EXPECT_GT(pictures, 0);
  EXPECT_GT(held_out, 0);
  EXPECT_EQ(pictures + held_out, all.at("pictures"));
  EXPECT_THAT(run_roomwise(with({"--visits", "1-2", "--held-out-visits", "2-"})).errors,
              HasSubstr("is both to be trained on and held out"));
  EXPECT_THAT(run_roomwise(with({"--visits", "7"})).errors, HasSubstr("in the visits 7"));
  EXPECT_THAT(run_roomwise(with({"--held-out-visits", "3-"})).errors,
              HasSubstr("in the visits 3-"));
  EXPECT_THAT(run_roomwise(with({"--held-out-visits", "1-"})).errors,
              HasSubstr("no pictures to train on"));
}

TEST_F(TrainCommandTest, SaysWhatIsWrong) {
  EXPECT_THAT(train("out", {"--momentum", "2"}).errors,
              HasSubstr("momentum is 2; expected a number"));
  EXPECT_THAT(train("out", {"--from-block", "conv9"}).errors,
              HasSubstr("no node or block \"conv9\""));
  EXPECT_THAT(train("out", {"--features", "pool"}).errors, HasSubstr("named \"pool\""));
  EXPECT_THAT(train("out", {"--held-out", path("no")}).errors, HasSubstr("no: cannot be read"));
  const auto resumed = train("out", {"--resume"});
  EXPECT_EQ(resumed.exit_code, 1);
  EXPECT_THAT(resumed.errors, HasSubstr("colors-trained.checkpoint"));
}

#else

TEST_F(TrainCommandTest, SaysThatThisBuildCannot) {
  const auto result = train("out", {});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors,
              HasSubstr("install libtorch-dev, libgloo-dev and libopenblas0-pthread"));
}

#endif

TEST_F(TrainCommandTest, WantsPictures) {
  const auto result =
      run_roomwise({"train", "--network", path("colors.onnx"), "--out", path("out")});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("give a FOLDER of classes or --home HOME"));
  EXPECT_EQ(run_roomwise({"train", "--schedule", "steep"}).exit_code, 2);
}

TEST_F(TrainCommandTest, RefusesOptionsOfOtherPictures) {
  const std::vector<std::string> to{"--network", path("colors.onnx"), "--out", path("out")};
  const auto refuses = [&](std::vector<std::string> arguments, const char* why) {
    arguments.insert(arguments.end(), to.begin(), to.end());
    const auto result = run_roomwise(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.errors, HasSubstr(why));
  };
  refuses({"train", path("photos"), "--visits", "1"}, "--visits requires --home");
  refuses({"train", path("photos"), "--held-out-visits", "1"}, "--held-out-visits requires --home");
  refuses({"train", "--home", path("a.home"), "--held-out", path("photos")},
          "--home excludes --held-out");
  refuses({"train", "--home", path("a.home"), "--held-out-share", "0.1"},
          "--home excludes --held-out-share");
  refuses({"train", path("photos"), "--held-out", path("photos"), "--held-out-share", "0.1"},
          "--held-out-share");
}

}  // namespace
}  // namespace roomwise
