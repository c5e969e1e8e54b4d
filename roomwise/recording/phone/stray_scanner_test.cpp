#include "roomwise/recording/phone/stray_scanner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/phone/testing/video_writer.h"
#include "roomwise/recording/phone/video_file.h"

// What LeakSanitizer must not report, since it is x265's, which writes the test's pictures: it
// leaks a few strings of each encoder.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libx265.so\n";
}

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;
using testing::brightness_of_grey_video;
using testing::write_grey_video;

constexpr int kStrayFrames = 20;

class VideoFileOf : public ::testing::TestWithParam<AVCodecID> {};

TEST_P(VideoFileOf, GivesEachPictureInAnyOrder) {
  if (avcodec_find_encoder(GetParam()) == nullptr) GTEST_SKIP() << "there is no encoder";
  const ScratchFolder folder;
  EXPECT_TRUE(write_grey_video(folder / "a.mp4", kStrayFrames, GetParam()));
  const auto video = VideoFile::open(folder / "a.mp4");
  ASSERT_OK(video);
  ASSERT_EQ((*video)->size(), std::size_t{kStrayFrames});
  for (const int place : {0, 1, 2, 3, 7, 19, 18, 4, 5, 5, 12, 0, 19}) {
    const auto picture = (*video)->read(static_cast<std::size_t>(place));
    ASSERT_OK(picture);
    EXPECT_EQ(picture->width(), 64);
    EXPECT_NEAR(picture->at(30, 20).r, brightness_of_grey_video(place), 3) << place;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, VideoFileOf,
                         ::testing::Values(AV_CODEC_ID_MPEG4, AV_CODEC_ID_HEVC));

TEST(VideoFile, SaysWhichFileIsNoVideoOrWasCutOff) {
  const ScratchFolder folder;
  EXPECT_ERROR(VideoFile::open(folder / "none.mp4"), "none.mp4: is no MP4 video");
  EXPECT_OK(write_file(folder / "text.mp4", std::string_view("no video")));
  EXPECT_ERROR(VideoFile::open(folder / "text.mp4"), "text.mp4: is no MP4 video");
  EXPECT_TRUE(write_grey_video(folder / "cut.mp4", kStrayFrames));
  const auto size = std::filesystem::file_size(folder / "cut.mp4");
  std::filesystem::resize_file(folder / "cut.mp4", size / 2);
  EXPECT_ERROR(VideoFile::open(folder / "cut.mp4"), "cut.mp4");
}

TEST(VideoFile, NeverTakesADamagedPictureForAnother) {
  const ScratchFolder folder;
  EXPECT_TRUE(write_grey_video(folder / "a.mp4", kStrayFrames));
  Bytes bytes = read_file(folder / "a.mp4").value();
  for (std::size_t at = 60; at < bytes.size() / 2; at += 7) {
    Bytes damaged = bytes;
    for (std::size_t i = at; i < at + 6; ++i) damaged[i] = 0xA5;
    EXPECT_OK(write_file(folder / "b.mp4", damaged));
    const auto video = VideoFile::open(folder / "b.mp4");
    if (!video) continue;
    for (std::size_t i = 0; i < (*video)->size(); ++i) static_cast<void>((*video)->read(i));
  }
}

// A walk as the app writes it: 1.5 m before a wall, 10 cm to the right a frame.
class StrayScannerFolder : public ::testing::Test {
 protected:
  StrayScannerFolder() {
    EXPECT_TRUE(write_grey_video(folder_ / "rgb.mp4", kStrayFrames));
    std::filesystem::create_directory(folder_ / "depth");
    for (int i = 0; i < kStrayFrames; ++i) {
      const image::DepthImage depth(16, 12, static_cast<std::uint16_t>(1500 + i));
      write(fmt::format("depth/{:06}.png", i), image::encode_png(depth));
    }
    write("camera_matrix.csv", "50, 0, 32\n0, 50, 23\n0, 0, 1\n");
    write("odometry.csv", odometry("timestamp, frame, x, y, z, qx, qy, qz, qw", ""));
  }
  // `more`: values after those of the pose.
  static std::string odometry(const std::string& header, const std::string& more) {
    std::string table = header + "\r\n";
    for (int i = 0; i < kStrayFrames; ++i) {
      table += fmt::format("{:.3f}, {:06}, {:.2f}, 0, 1.5, 1, 0, 0, 0{}\r\n", 7 + 0.017 * i, i,
                           0.1 * i, more);
    }
    return table;
  }
  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    EXPECT_OK(write_file(folder_ / name, content));
  }
  [[nodiscard]] auto open() const { return open_recording(folder_.path()); }

  ScratchFolder folder_;
};

TEST_F(StrayScannerFolder, IsToldByItsContentAndMatchesTheVideoByOrder) {
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "Stray Scanner");
  EXPECT_EQ((*recording)->frames().size(), std::size_t{kStrayFrames});
  for (const std::uint64_t index : {3U, 17U, 4U}) {
    const auto frame = (*recording)->frame(index);
    ASSERT_OK(frame);
    EXPECT_EQ((*frame)->timestamp_ns, 7'000'000'000 + 17'000'000 * static_cast<TimestampNs>(index));
    EXPECT_NEAR((*frame)->color.at(30, 20).r, brightness_of_grey_video(static_cast<int>(index)), 4);
    EXPECT_EQ((*frame)->depth.at(30, 20), 1500 + index);
  }
  EXPECT_THAT((*recording)->describe((*recording)->pictures()[3]), ::testing::HasSubstr("rgb.mp4"));
}

TEST_F(StrayScannerFolder, TakesPosesAsTheyAre) {
  const auto poses = open().value()->device_poses();
  ASSERT_EQ(poses.size(), std::size_t{kStrayFrames});
  const auto& pose = poses[5].world_from_camera;
  EXPECT_LT((pose.translation - Eigen::Vector3d(0.5, 0, 1.5)).norm(), 1e-9);
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  const auto motion = open().value()->frame(5).value()->device_motion;
  ASSERT_TRUE(motion && motion->up_camera);
  EXPECT_LT((*motion->up_camera + Eigen::Vector3d::UnitY()).norm(), 1e-9) << "y of its world is up";
}

TEST_F(StrayScannerFolder, ReadsTheCamerasOfNewerTablesByTheirHeader) {
  write("odometry.csv",
        odometry("timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy", ", 60, 61, 31, 22"));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->info().camera.fx, 60);
  EXPECT_EQ((*recording)->info().camera.cy, 22);
}

TEST_F(StrayScannerFolder, NamesTheLineThatIsDamaged) {
  const std::string header = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  const auto is_refused = [&](const std::string& line, const char* why) {
    write("odometry.csv", header + line);
    const auto opened = open();
    EXPECT_ERROR(opened, why);
    EXPECT_ERROR(opened, "odometry.csv:2");
  };
  is_refused("7, 0, 0, 0, 0, 0, 0, 0\n", "has 8 values, the header 9");
  is_refused("x, 0, 0, 0, 0, 0, 0, 0, 1\n", "x");
  is_refused("7, 0, nan, 0, 0, 0, 0, 0, 1\n", "x = 'nan'");
  is_refused("7, 0, 0, 0, 0, 0, 0, 0, 9\n", "has not the length 1");
  write("odometry.csv", std::string_view("a,b\n1,2\n"));
  EXPECT_ERROR(open(), "odometry.csv:1: has no column 'timestamp'");
  write("odometry.csv", std::string_view(""));
  EXPECT_ERROR(open(), "odometry.csv: holds no frame");
}

TEST_F(StrayScannerFolder, GoesOnBehindALineThatIsDamaged) {
  std::string table = read_text_file(folder_ / "odometry.csv").value();
  const std::size_t line = table.find("7.051, 000003");
  ASSERT_NE(line, table.npos);
  write("odometry.csv", table.replace(line, 5, "x.051"));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_ERROR((*recording)->next(), "odometry.csv:5");
  EXPECT_EQ((*recording)->frames().size(), std::size_t{kStrayFrames - 1});
  EXPECT_EQ((*recording)->find(3), nullptr);
  EXPECT_NEAR((*recording)->read_color(4)->at(30, 20).r, brightness_of_grey_video(4), 4)
      << "each line behind it has its own picture";
}

TEST_F(StrayScannerFolder, LosesALineWhoseTimeOrNumberDoesNotFitAlone) {
  const std::string table = read_text_file(folder_ / "odometry.csv").value();
  for (const char* line : {"900.51, 000003", "0.510, 000003", "7.051, 900003", "7.051, 000000"}) {
    std::string damaged = table;
    write("odometry.csv", damaged.replace(damaged.find("7.051, 000003"), 13, line));
    const auto recording = open();
    ASSERT_OK(recording);
    EXPECT_EQ((*recording)->frames().size(), std::size_t{kStrayFrames - 1}) << line;
    ASSERT_EQ((*recording)->damaged().size(), 1U) << line;
    EXPECT_EQ((*recording)->damaged().front().index, 3U);
    EXPECT_THAT((*recording)->damaged().front().why, ::testing::HasSubstr("odometry.csv:5: its "));
  }
}

TEST_F(StrayScannerFolder, GivesWhatComesBeforeTheEndOfAVideoThatIsShorter) {
  EXPECT_TRUE(write_grey_video(folder_ / "rgb.mp4", kStrayFrames - 1));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->frames().size(), std::size_t{kStrayFrames - 1});
  EXPECT_THAT((*recording)->notes(), ::testing::ElementsAre(::testing::HasSubstr(
                                         "rgb.mp4 has 19 pictures, odometry.csv 20 frames")));
}

TEST_F(StrayScannerFolder, LeavesALineOutWithinWhichTheTableEnds) {
  const std::string table = read_text_file(folder_ / "odometry.csv").value();
  for (const std::size_t cut : {2U, 4U, 30U}) {
    write("odometry.csv", std::string_view(table).substr(0, table.size() - cut));
    const auto recording = open();
    ASSERT_OK(recording);
    EXPECT_EQ((*recording)->frames().size(), std::size_t{kStrayFrames - 1}) << cut;
    EXPECT_THAT((*recording)->notes(),
                ::testing::ElementsAre(::testing::HasSubstr("ends within line 21")));
  }
}

// With its index in front, as some phones write it.
TEST_F(StrayScannerFolder, GivesWhatComesBeforeTheEndOfAVideoThatWasCutOff) {
  EXPECT_TRUE(write_grey_video(folder_ / "rgb.mp4", kStrayFrames, AV_CODEC_ID_MPEG4, 6, 64, 48,
                               /*index_first=*/true));
  const auto whole = std::filesystem::file_size(folder_ / "rgb.mp4");
  EXPECT_EQ(open().value()->frames().size(), std::size_t{kStrayFrames});
  std::filesystem::resize_file(folder_ / "rgb.mp4", whole - 1);
  std::size_t before = kStrayFrames;
  for (auto size = whole - 1; size > whole / 2; size -= 40) {
    std::filesystem::resize_file(folder_ / "rgb.mp4", size);
    const auto recording = open();
    if (!recording) break;  // before the first picture
    const auto& frames = (*recording)->frames();
    EXPECT_LE(frames.size(), before);
    EXPECT_LT(frames.size(), std::size_t{kStrayFrames});
    EXPECT_THAT((*recording)->notes(), ::testing::SizeIs(1));
    before = frames.size();
    for (const std::uint64_t index : frames) {
      const auto color = (*recording)->read_color(index);
      ASSERT_OK(color);
      EXPECT_NEAR(color->at(30, 20).r, brightness_of_grey_video(static_cast<int>(index)), 4);
    }
  }
  EXPECT_LT(before, std::size_t{kStrayFrames / 2 + 4});
}

}  // namespace
}  // namespace roomwise::recording
