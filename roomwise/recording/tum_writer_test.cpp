#include "roomwise/recording/tum_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/full_disk.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::FullDisk;
using roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const geometry::PinholeCamera kCamera{7, 7, 4, 3, 8, 6, {0.1, 0, 0, 0, 0.5}, 5000};

image::RgbdFrame raw_frame(int number) {
  image::RgbdFrame frame;
  frame.index = static_cast<std::uint64_t>(100 + number);  // the writer counts for itself
  frame.timestamp_ns = 1'000'000'000 + TimestampNs{number} * 33'333'333;
  frame.color =
      image::ColorImage(kCamera.width, kCamera.height, {static_cast<std::uint8_t>(number), 50, 90});
  frame.depth =
      image::DepthImage(kCamera.width, kCamera.height, static_cast<std::uint16_t>(1000 + number));
  return frame;
}

std::vector<image::RgbdFrame> read_all(const std::filesystem::path& folder) {
  std::vector<image::RgbdFrame> frames;
  auto recording = TumRecording::open(folder);
  EXPECT_OK(recording);
  while (recording) {
    auto frame = (*recording)->next();
    EXPECT_OK(frame);
    if (!frame || !frame->has_value()) break;
    frames.push_back(**std::move(frame));
  }
  return frames;
}

class TumWriterFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    auto writer = TumWriter::create(folder_, kCamera);
    ASSERT_OK(writer);
    writer_ = *std::move(writer);
  }

  ScratchFolder scratch_;
  std::filesystem::path folder_ = scratch_ / "recordings/home";
  std::unique_ptr<TumWriter> writer_;
};

TEST_F(TumWriterFolder, WritesRawFramesThatAreReadBack) {
  for (int i = 0; i < 3; ++i) ASSERT_OK(writer_->write(raw_frame(i)));
  EXPECT_EQ(writer_->frames_written(), 3U);
  ASSERT_OK(writer_->close());
  EXPECT_EQ(TumRecording::open(folder_).value()->info().camera, kCamera);
  const auto frames = read_all(folder_);
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.index, static_cast<std::uint64_t>(i));
    EXPECT_EQ(frame.timestamp_ns, raw_frame(i).timestamp_ns);
    EXPECT_EQ(frame.depth, raw_frame(i).depth);
    EXPECT_NEAR(frame.color.at(4, 4).g, 50, 3);
    EXPECT_TRUE(image::is_jpeg(frame.encoded_color));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "rooms.txt")) << "no room was named";
}

TEST_F(TumWriterFolder, KeepsEncodedImagesAsTheyAre) {
  image::RgbdFrame png = raw_frame(0);
  png.encoded_color = image::encode_png(png.color);
  png.encoded_depth = image::encode_png(png.depth);
  image::RgbdFrame jpeg = raw_frame(1);
  jpeg.encoded_color = image::encode_jpeg(jpeg.color, 30);
  ASSERT_OK(writer_->write(png));
  ASSERT_OK(writer_->write(jpeg));
  ASSERT_OK(writer_->close());
  const auto frames = read_all(folder_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].encoded_color, png.encoded_color);
  EXPECT_EQ(frames[0].encoded_depth, png.encoded_depth);
  EXPECT_EQ(frames[1].encoded_color, jpeg.encoded_color);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "rgb/1.000000.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "rgb/1.033333333.jpg"));
}

TEST_F(TumWriterFolder, KeepsNothingOfWhereAndByWhomAPictureWasTaken) {
  image::RgbdFrame frame = raw_frame(0);
  const Bytes plain = image::encode_jpeg(frame.color, 90);
  frame.encoded_color =
      image::testing::with_exif(plain, image::testing::exif_with_place(image::kUpright));
  ASSERT_OK(writer_->write(frame));
  ASSERT_OK(writer_->close());
  const Bytes stored = read_file(folder_ / "rgb/1.000000.jpg").value();
  EXPECT_EQ(image::testing::secrets_in(stored), "");
  EXPECT_EQ(image::decode_color(stored).value(), image::decode_color(plain).value());
}

TEST_F(TumWriterFolder, KeepsTheDevicesMotion) {
  image::RgbdFrame first = raw_frame(0);
  first.device_motion = geometry::DeviceMotion{{Eigen::Quaterniond(0.6, 0.8, 0, 0), {1, 2, 3}},
                                               Eigen::Vector3d(0, 0.96, 0.28)};
  ASSERT_OK(writer_->write(first));
  ASSERT_OK(writer_->write(raw_frame(1)));
  const auto frames = read_all(folder_);
  ASSERT_EQ(frames.size(), 2U) << "as after a kill: nothing was closed";
  ASSERT_TRUE(frames[0].device_motion);
  EXPECT_TRUE(frames[0].device_motion->world_from_camera.translation.isApprox(
      first.device_motion->world_from_camera.translation, 1e-9));
  EXPECT_TRUE(frames[0].device_motion->up_camera->isApprox(*first.device_motion->up_camera, 1e-6));
  EXPECT_FALSE(frames[1].device_motion);
}

TEST_F(TumWriterFolder, KeepsHowSureTheDeviceIsAndReadsOverIt) {
  image::RgbdFrame frame = raw_frame(0);
  frame.device_motion = geometry::DeviceMotion{{Eigen::Quaterniond::Identity(), {1, 2, 3}}};
  ASSERT_OK(writer_->write(frame, PoseCovariance(0.25 * PoseCovariance::Identity())));
  EXPECT_THAT(read_text_file(folder_ / "odometry.txt").value(),
              HasSubstr(" # covariance 0.25 0 0 0 0 0 0.25 "));
  EXPECT_TRUE(read_all(folder_).at(0).device_motion);
}

TEST_F(TumWriterFolder, AMotionThatWasCutOffInItsLastLineIsReadUpToThere) {
  for (int i = 0; i < 2; ++i) {
    image::RgbdFrame frame = raw_frame(i);
    frame.device_motion = geometry::DeviceMotion{{Eigen::Quaterniond::Identity(), {1, 2, 3}}};
    ASSERT_OK(writer_->write(frame));
  }
  const std::string text = read_text_file(folder_ / "odometry.txt").value();
  ASSERT_OK(write_file(folder_ / "odometry.txt", text.substr(0, text.size() - 30)));
  const auto frames = read_all(folder_);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_TRUE(frames[0].device_motion);
  EXPECT_FALSE(frames[1].device_motion);
}

TEST_F(TumWriterFolder, CanBeReadWhileItIsWritten) {
  ASSERT_OK(writer_->write(raw_frame(0)));
  ASSERT_OK(writer_->write(raw_frame(1)));
  EXPECT_EQ(read_all(folder_).size(), 2U) << "as after a kill: nothing was closed";
}

TEST_F(TumWriterFolder, NumbersTheVisitsOfRooms) {
  const auto write = [&](int first, int last) {
    for (int i = first; i <= last; ++i) ASSERT_OK(writer_->write(raw_frame(i)));
  };
  write(0, 1);  // in no room yet
  ASSERT_OK(writer_->name_room("hall"));
  write(2, 3);
  ASSERT_OK(writer_->name_room("hall"));  // still there
  write(4, 4);
  ASSERT_OK(writer_->name_room("living room"));
  EXPECT_THAT(RoomLabels::read(folder_ / "rooms.txt")->ranges(),
              ElementsAre(RoomRange{2, 4, "hall", 1}))
      << "up to date at each change";
  write(5, 6);
  ASSERT_OK(writer_->name_room("bath"));  // no frame of it
  ASSERT_OK(writer_->name_room("hall"));
  write(7, 7);
  ASSERT_OK(writer_->name_room(std::nullopt));
  write(8, 8);
  ASSERT_OK(writer_->name_room("hall"));
  write(9, 9);
  ASSERT_OK(writer_->close());
  EXPECT_THAT(RoomLabels::read(folder_ / "rooms.txt")->ranges(),
              ElementsAre(RoomRange{2, 4, "hall", 1}, RoomRange{5, 6, "living room", 1},
                          RoomRange{7, 7, "hall", 2}, RoomRange{9, 9, "hall", 3}));
}

TEST_F(TumWriterFolder, AKillLosesTheRoomsOfAFewSecondsAtMost) {
  const auto rooms = [&] { return RoomLabels::read(folder_ / "rooms.txt").value().ranges(); };
  ASSERT_OK(writer_->name_room("hall"));
  ASSERT_OK(writer_->write(raw_frame(0)));
  EXPECT_THAT(rooms(), ElementsAre(RoomRange{0, 0, "hall", 1})) << "as the visit begins";
  int last = 0;
  while (rooms().back().last_frame == 0) {
    ASSERT_OK(writer_->write(raw_frame(++last)));
    ASSERT_LE(last, 200);
  }
  EXPECT_EQ(rooms().back().last_frame, static_cast<std::uint64_t>(last));
  EXPECT_GT(last, 100) << "not with every frame";
}

TEST_F(TumWriterFolder, AClosingThatFailedIsTriedAgain) {
  ASSERT_OK(writer_->name_room("hall"));
  for (int i = 0; i < 3; ++i) ASSERT_OK(writer_->write(raw_frame(i)));
  {
    const FullDisk full(10);
    EXPECT_FALSE(writer_->close());
  }
  ASSERT_OK(writer_->close());
  EXPECT_THAT(RoomLabels::read(folder_ / "rooms.txt")->ranges(),
              ElementsAre(RoomRange{0, 2, "hall", 1}));
}

TEST_F(TumWriterFolder, RefusesWhatCouldNotBeReadBack) {
  ASSERT_OK(writer_->write(raw_frame(3)));
  EXPECT_ERROR(writer_->write(raw_frame(3)), "does not increase");
  EXPECT_ERROR(writer_->write(raw_frame(2)), "does not increase");
  image::RgbdFrame other_size = raw_frame(4);
  other_size.depth = image::DepthImage(4, 4);
  EXPECT_ERROR(writer_->write(other_size), "4x4 depth pixels, the camera 8x6");
  image::RgbdFrame foreign = raw_frame(4);
  foreign.encoded_color = {1, 2, 3, 4};
  EXPECT_ERROR(writer_->write(foreign), "not JPEG or PNG");
  EXPECT_ERROR(writer_->name_room(""), "no name for a room");
  ASSERT_OK(writer_->close());
  ASSERT_OK(writer_->close());
  EXPECT_ERROR(writer_->write(raw_frame(5)), "is closed");
  EXPECT_EQ(read_all(folder_).size(), 1U);
}

TEST_F(TumWriterFolder, RefusesAFolderThatIsNotEmpty) {
  EXPECT_ERROR(TumWriter::create(folder_, kCamera), "is there and not empty");
  std::filesystem::create_directories(scratch_ / "empty");
  EXPECT_OK(TumWriter::create(scratch_ / "empty", kCamera));
  ASSERT_OK(write_file(scratch_ / "file", "text"));
  EXPECT_ERROR(TumWriter::create(scratch_ / "file", kCamera), (scratch_ / "file").string());
}

TEST_F(TumWriterFolder, StaysValidWhenAnImageFindsTheDiskFull) {
  ASSERT_OK(writer_->write(raw_frame(0)));
  {
    const FullDisk full(100);
    EXPECT_ERROR(writer_->write(raw_frame(1)), "cannot be written");
  }
  EXPECT_EQ(read_all(folder_).size(), 1U);
  ASSERT_OK(writer_->write(raw_frame(1)));  // there is space again
  ASSERT_OK(writer_->close());
  EXPECT_EQ(read_all(folder_).size(), 2U);
}

TEST_F(TumWriterFolder, StaysValidWhenAListFindsTheDiskFull) {
  // Images that are smaller than the list.
  image::RgbdFrame frame = raw_frame(0);
  frame.encoded_color = image::encode_png(frame.color);
  frame.encoded_depth = image::encode_png(frame.depth);
  const std::size_t largest = std::max(frame.encoded_color.size(), frame.encoded_depth.size());
  int written = 0;
  {
    const FullDisk full(10 * largest + 7);
    for (;; ++written) {
      ASSERT_LT(written, 1000);
      frame.timestamp_ns = raw_frame(written).timestamp_ns;
      const auto result = writer_->write(frame);
      if (result) continue;
      EXPECT_ERROR(result, ".txt: cannot be written");
      break;
    }
  }
  EXPECT_GT(written, 0);
  EXPECT_EQ(read_all(folder_).size(), static_cast<std::size_t>(written));
  ASSERT_OK(writer_->write(frame));
  EXPECT_EQ(read_all(folder_).size(), static_cast<std::size_t>(written) + 1);
}

TEST(TumWriterOfRealData, CopiesARecordingByteForByte) {
  const auto desk = roomwise::testing::find_data("tum_fr1_desk_9frames");
  ROOMWISE_REQUIRE_FILE(desk);
  RecordingOptions options;
  options.camera = geometry::camera_preset("fr1").value();
  auto recording = TumRecording::open(*desk, options);
  ASSERT_OK(recording);
  const ScratchFolder scratch;
  auto writer = TumWriter::create(scratch / "copy", *options.camera);
  ASSERT_OK(writer);
  std::vector<image::RgbdFrame> originals;
  for (;;) {
    auto frame = (*recording)->next();
    ASSERT_OK(frame);
    if (!frame->has_value()) break;
    ASSERT_OK((*writer)->write(**frame));
    originals.push_back(**std::move(frame));
  }
  ASSERT_OK((*writer)->close());
  const auto copies = read_all(scratch / "copy");
  ASSERT_EQ(copies.size(), originals.size());
  for (std::size_t i = 0; i < copies.size(); ++i) {
    EXPECT_EQ(copies[i].timestamp_ns, originals[i].timestamp_ns);
    EXPECT_EQ(copies[i].encoded_color, originals[i].encoded_color);
    EXPECT_EQ(copies[i].encoded_depth, originals[i].encoded_depth);
  }
}

}  // namespace
}  // namespace roomwise::recording
