#include "roomwise/recording/phone/scanner_app.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::recording {
namespace {

using nlohmann::json;
using roomwise::testing::ScratchFolder;

constexpr int kWidth_px = 64, kHeight_px = 48;

json frame_json(int number) {
  return {{"time", 100 + 0.2 * number},
          {"intrinsics", {50 + number, 0, 32, 0, 50 + number, 23, 0, 0, 1}},
          {"cameraPoseARFrame", {1, 0, 0, 0.5 * number, 0, 1, 0, 1.5, 0, 0, 1, 0, 0, 0, 0, 1}},
          {"latitude", 50.1},
          {"longitude", 8.7}};
}

// Six frames as the app writes them; every third has a picture, of brightness 10 * its number.
class ScannerAppFolder : public ::testing::Test {
 protected:
  ScannerAppFolder() {
    for (int i = 0; i < 6; ++i) {
      write(i, "frame_{:05}.json", frame_json(i).dump());
      image::DepthImage depth(16, 12, static_cast<std::uint16_t>(1000 + i));
      write(i, "depth_{:05}.png", image::encode_png(depth));
      const auto grey = static_cast<std::uint8_t>(10 * i);
      const image::ColorImage color(kWidth_px, kHeight_px, {grey, grey, grey});
      if (i % 3 == 0) write(i, "frame_{:05}.jpg", image::encode_jpeg(color, 95));
    }
  }
  template <typename Content>  // text or bytes
  void write(int number, const char* name, const Content& content) const {
    EXPECT_OK(write_file(file(number, name), content));
  }
  [[nodiscard]] std::filesystem::path file(int number, const char* name) const {
    return folder_ / fmt::format(fmt::runtime(name), number);
  }
  [[nodiscard]] auto open() const { return open_recording(folder_.path()); }

  ScratchFolder folder_;
};

TEST_F(ScannerAppFolder, IsToldWithoutAnyOptionAndGivesItsFramesByTheirNumbers) {
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "3D Scanner App, All Data");
  EXPECT_THAT((*recording)->frames(), ::testing::ElementsAre(0, 3));
  const auto frame = (*recording)->frame(3);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->timestamp_ns, 100'600'000'000);
  EXPECT_EQ((*frame)->color.width(), kWidth_px);
  EXPECT_NEAR((*frame)->color.at(30, 20).r, 30, 1);
  EXPECT_EQ((*frame)->depth.width(), kWidth_px);
  EXPECT_EQ((*frame)->depth.at(30, 20), 1003);
  EXPECT_EQ(image::decode_color((*frame)->encoded_color).value(), (*frame)->color);
  EXPECT_EQ(image::decode_depth((*frame)->encoded_depth).value(), (*frame)->depth);
}

TEST_F(ScannerAppFolder, GivesThePosesOfAllFramesInOurAxes) {
  const auto recording = open();
  ASSERT_OK(recording);
  const Trajectory& poses = (*recording)->device_poses();
  ASSERT_EQ(poses.size(), 6U) << "also of those without a picture";
  const auto& pose = poses[4].world_from_camera;
  EXPECT_EQ(poses[4].timestamp_ns, 100'800'000'000);
  EXPECT_LT((pose.translation - Eigen::Vector3d(2, 1.5, 0)).norm(), 1e-12);
  const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d down = pose.rotation * Eigen::Vector3d::UnitY();
  EXPECT_LT((ahead - Eigen::Vector3d(0, 0, -1)).norm(), 1e-12) << "ARKit looks along -z";
  EXPECT_LT((down - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12) << "and its y is up";
  EXPECT_EQ(read_truth(folder_.path())->size(), 6U);
  const auto motion = (*recording)->frame(0).value()->device_motion;
  ASSERT_TRUE(motion) << "what ARKit said while it recorded";
  EXPECT_LT(
      (motion->world_from_camera.rotation * *motion->up_camera - Eigen::Vector3d::UnitY()).norm(),
      1e-12);
}

// Its depth lies as the sensor read it, whatever the picture's Exif says of turning it.
TEST_F(ScannerAppFolder, IsNotTurnedByTheExifOfAPicture) {
  image::ColorImage color(kWidth_px, kHeight_px, {200, 200, 200});
  for (int y = 0; y < kHeight_px / 2; ++y) {
    for (int x = 0; x < kWidth_px; ++x) color.at(x, y) = {20, 20, 20};
  }
  write(3, "frame_{:05}.jpg",
        image::testing::with_exif(image::encode_jpeg(color, 95),
                                  image::testing::exif_with_place(3)));  // upside down
  const auto frame = open().value()->frame(3);
  ASSERT_OK(frame);
  EXPECT_NEAR((*frame)->color.at(30, 8).r, 20, 2);
  EXPECT_NEAR((*frame)->color.at(30, 40).r, 200, 2);
}

TEST_F(ScannerAppFolder, GivesDepthBetweenPicturesWithTheFrameBefore) {
  ASSERT_OK(write_file(file(4, "depth_{:05}.png"), std::string("no picture")));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_THAT((*recording)->notes(),
              ::testing::Contains(::testing::StartsWith("4 depth images between pictures")));
  const image::RgbdFrame first = *(*recording)->frame(0).value();
  ASSERT_EQ(first.depth_views.size(), 2U) << "frames 1 and 2";
  const image::DepthView& second = first.depth_views[1];
  EXPECT_EQ(second.timestamp_ns, 100'400'000'000);
  EXPECT_LT((second.frame_from_view.translation - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(image::decode_depth(second.encoded_depth).value().at(30, 20), 1002);
  const image::RgbdFrame last = *(*recording)->frame(3).value();
  ASSERT_EQ(last.depth_views.size(), 1U) << "what cannot be read is passed over";
  EXPECT_EQ(image::decode_depth(last.depth_views[0].encoded_depth).value().at(30, 20), 1005);
}

// The phone is held upright, its sensor's left side above: columns of a picture are rows of the
// room.
TEST_F(ScannerAppFolder, TurnsPicturesUprightByThePoses) {
  for (int i = 0; i < 6; ++i) {
    json frame = frame_json(i);
    frame["cameraPoseARFrame"] = {0, 1, 0, 0.5 * i, -1, 0, 0, 1.5, 0, 0, 1, 0, 0, 0, 0, 1};
    write(i, "frame_{:05}.json", frame.dump());
  }
  image::ColorImage color(kWidth_px, kHeight_px, {200, 200, 200});
  image::DepthImage depth(16, 12, 2000);
  for (int y = 0; y < kHeight_px; ++y) {
    for (int x = 0; x < kWidth_px / 2; ++x) color.at(x, y) = {20, 20, 20};
  }
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 8; ++x) depth.at(x, y) = 1000;
  }
  write(3, "frame_{:05}.jpg", image::encode_jpeg(color, 95));
  write(3, "depth_{:05}.png", image::encode_png(depth));

  const auto recording = open();
  ASSERT_OK(recording);
  const geometry::PinholeCamera& camera = (*recording)->info().camera;
  EXPECT_EQ(camera.width, kHeight_px);
  EXPECT_EQ(camera.height, kWidth_px);
  EXPECT_EQ((*recording)->original_camera((*recording)->pictures()[1]).width, kHeight_px);
  const image::RgbdFrame frame = *(*recording)->frame(3).value();
  EXPECT_NEAR(frame.color.at(24, 8).r, 20, 2) << "what was at the left is above";
  EXPECT_NEAR(frame.color.at(24, 56).r, 200, 2);
  EXPECT_EQ(frame.depth.at(24, 8), 1000);
  EXPECT_EQ(frame.depth.at(24, 56), 2000);
  EXPECT_EQ(image::decode_color(frame.encoded_color).value(), frame.color);
  EXPECT_EQ((*recording)->read_color(3).value(), frame.color);
  ASSERT_TRUE(frame.device_motion);
  EXPECT_LT((*frame.device_motion->up_camera + Eigen::Vector3d::UnitY()).norm(), 1e-12)
      << "up is above in the picture";
  EXPECT_LT(
      (frame.device_motion->world_from_camera.translation - Eigen::Vector3d(1.5, 1.5, 0)).norm(),
      1e-12);
  EXPECT_THAT((*recording)->notes(),
              ::testing::Contains(::testing::HasSubstr("turned by a quarter to the right")));
}

TEST_F(ScannerAppFolder, TakesAPictureWithoutDepthAsNoFrame) {
  std::filesystem::remove(file(3, "depth_{:05}.png"));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_THAT((*recording)->frames(), ::testing::ElementsAre(0));
  EXPECT_THAT((*recording)->notes(),
              ::testing::Contains(::testing::HasSubstr("1 of 2 pictures have no depth image")));
  EXPECT_OK((*recording)->read_color(3));
}

TEST_F(ScannerAppFolder, RefusesAnotherCamera) {
  const auto own = open().value()->info().camera;
  EXPECT_OK(open_recording(folder_.path(), {.camera = own}));
  geometry::PinholeCamera other = own;
  other.fx += 1;
  EXPECT_ERROR(open_recording(folder_.path(), {.camera = other}), "says itself which camera");
}

TEST_F(ScannerAppFolder, NamesTheFileThatIsDamagedAndGivesTheOtherFrames) {
  const auto is_left_out = [&](const char* why) {
    const auto opened = open();
    ASSERT_OK(opened);
    EXPECT_THAT((*opened)->frames(), ::testing::ElementsAre(0));
    EXPECT_EQ((*opened)->device_poses().size(), 5U);
    ASSERT_EQ((*opened)->damaged().size(), 1U);
    EXPECT_EQ((*opened)->damaged().front().index, 3U);
    const auto first = (*opened)->next();
    EXPECT_ERROR(first, why);
    EXPECT_ERROR(first, "frame_00003");
    EXPECT_EQ((*opened)->next().value()->index, 0U) << "it is told at once, and but once";
    EXPECT_FALSE((*opened)->next().value().has_value());
  };
  const auto is_left_out_with = [&](const json& content, const char* why) {
    write(3, "frame_{:05}.json", content.dump());
    is_left_out(why);
  };
  json three = frame_json(3);
  three["time"] = 99;
  is_left_out_with(three, "does not fit");
  three["time"] = 100'000;
  is_left_out_with(three, "does not fit");
  three = frame_json(3);
  three.erase("time");
  is_left_out_with(three, "'time' is missing");
  three = frame_json(3);
  three["intrinsics"] = {1, 2};
  is_left_out_with(three, "no list of 9 numbers");
  three = frame_json(3);
  three["cameraPoseARFrame"][0] = 7;
  is_left_out_with(three, "no rotation");
  three["cameraPoseARFrame"][0] = nullptr;
  is_left_out_with(three, "no finite number");
  is_left_out_with("text", "no JSON object");
  write(3, "frame_{:05}.json", std::string_view("{\"time\": 1"));
  is_left_out("frame_00003.json: is no JSON object");
  std::filesystem::resize_file(file(3, "frame_{:05}.json"), 1 << 21);
  is_left_out("more than");
  std::filesystem::remove(file(3, "frame_{:05}.json"));
  is_left_out("frame_00003.jpg: has no .json of its number");
}

TEST_F(ScannerAppFolder, LosesNoFrameBehindATimeThatIsFarTooLate) {
  json one = frame_json(1);
  one["time"] = 100'000;
  write(1, "frame_{:05}.json", one.dump());
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), ::testing::ElementsAre(0, 3));
  EXPECT_THAT((*opened)->damaged(), ::testing::IsEmpty()) << "it has no picture";
  EXPECT_EQ((*opened)->device_poses().size(), 5U);
}

TEST_F(ScannerAppFolder, GivesACameraThatCannotBeAsDamage) {
  json three = frame_json(3);
  three["intrinsics"][0] = -1;
  write(3, "frame_{:05}.json", three.dump());
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->next(), "frame_00003.jpg: its camera: ");
  EXPECT_EQ((*opened)->next().value()->index, 0U);
}

TEST_F(ScannerAppFolder, SaysHowManyPosesOfNoPictureAreLost) {
  const auto tells = ::testing::Contains(::testing::AllOf(
      ::testing::HasSubstr("the poses of 1 frames"), ::testing::HasSubstr("frame_00001.json")));
  EXPECT_THAT(open().value()->notes(), ::testing::Not(tells));
  write(1, "frame_{:05}.json", std::string_view("{\"time\": 1"));
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->damaged(), ::testing::IsEmpty());
  EXPECT_THAT((*opened)->notes(), tells);
  EXPECT_EQ((*opened)->device_poses().size(), 5U);
}

TEST_F(ScannerAppFolder, SaysThatItTellsWhereItWasRecorded) {
  EXPECT_EQ(open().value()->info().personal_data, (image::PersonalData{true, false, false}));
  EXPECT_OK(write_file(folder_ / "info.json", std::string_view(R"({"deviceName": "Jane's"})")));
  EXPECT_EQ(open().value()->info().personal_data, (image::PersonalData{true, true, false}));
}

TEST_F(ScannerAppFolder, NamesThePictureThatCannotBeRead) {
  write(3, "frame_{:05}.jpg", image::encode_jpeg(image::ColorImage(8, 8), 90));
  EXPECT_ERROR(open().value()->frame(3), "frame_00003.jpg: has 8x8 pixels");
  write(3, "frame_{:05}.jpg", std::string_view("no picture"));
  EXPECT_ERROR(open().value()->frame(3), "frame_00003.jpg");
  write(0, "depth_{:05}.png", std::string_view("no picture"));
  EXPECT_ERROR(open().value()->frame(0), "depth_00000.png");
}

TEST_F(ScannerAppFolder, RefusesDepthOfAnotherShape) {
  write(3, "depth_{:05}.png", image::encode_png(image::DepthImage(16, 16, 1000)));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_OK((*recording)->frame(0));
  EXPECT_ERROR(
      (*recording)->frame(3),
      "depth_00003.png: has 16x16 pixels, which is another shape than its picture's 64x48");
}

TEST_F(ScannerAppFolder, OneOddPictureAtTheBeginningCostsItselfAlone) {
  write(0, "frame_{:05}.jpg", image::encode_jpeg(image::ColorImage(48, 48), 90));
  for (int i = 6; i < 9; ++i) {
    write(i, "frame_{:05}.json", frame_json(i).dump());
    write(i, "depth_{:05}.png", image::encode_png(image::DepthImage(16, 12, 1000)));
    write(i, "frame_{:05}.jpg", image::encode_jpeg(image::ColorImage(kWidth_px, kHeight_px), 90));
  }
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_ERROR((*recording)->frame(0),
               "frame_00000.jpg: has 48x48 pixels, the recording's other pictures 64x48");
  EXPECT_OK((*recording)->frame(3));
  EXPECT_OK((*recording)->frame(8));
}

TEST_F(ScannerAppFolder, WantsOneFrameThatIsWhole) {
  std::filesystem::remove(file(0, "frame_{:05}.json"));
  std::filesystem::remove(file(3, "frame_{:05}.json"));
  EXPECT_ERROR(open(), "none of its 2 frames can be read; the first: ");
  std::filesystem::remove(file(3, "frame_{:05}.jpg"));
  std::filesystem::remove(file(0, "frame_{:05}.jpg"));
  EXPECT_ERROR(open(), "holds no picture");
}

TEST(ScannerAppOfRealData, ReadsACorridor) {
  const auto folder = roomwise::testing::find_data("phone_corridor");
  if (!folder) GTEST_SKIP() << "there is no phone_corridor";
  const auto recording = open_recording(*folder);
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->frames().size(), 146U);
  EXPECT_EQ((*recording)->device_poses().size(), 436U);
  EXPECT_EQ((*recording)->info().camera.width, 640);
  const auto frame = (*recording)->frame(435);
  ASSERT_OK(frame);
  EXPECT_TRUE(frame->has_value());
}

}  // namespace
}  // namespace roomwise::recording
