#include "roomwise/recording/phone/record3d.h"

#include <gmock/gmock.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/bytes/testing/exr_writer.h"
#include "roomwise/recording/bytes/testing/quick_file.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/phone/testing/record3d_writer.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;
using ::testing::ElementsAre;
using ::testing::SizeIs;

class Record3dTest : public ::testing::Test {
 protected:
  Expected<std::unique_ptr<Recording>> open(const ZipContents& files) {
    EXPECT_TRUE(write_zip(path_, files));
    return open_record3d(path_, {});
  }
  const roomwise::testing::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "room.r3d";
  ZipContents files_ = phone_files();
};

TEST_F(Record3dTest, GivesFramesAndPoses) {
  const auto opened = open(files_);
  ASSERT_OK(opened);
  const Recording& recording = **opened;
  EXPECT_TRUE(is_record3d_file(path_));
  EXPECT_EQ(recording.info().camera.width, 48);
  EXPECT_EQ(recording.info().camera.fy, 61);
  EXPECT_EQ(recording.info().camera.cx, 23.5);
  EXPECT_THAT(recording.frames(), ElementsAre(0, 1));
  EXPECT_EQ(recording.pictures()[1].timestamp_ns, 10'600'000'000);
  const auto frame = recording.frame(1);
  ASSERT_OK(frame);
  EXPECT_NEAR((*frame)->color.at(20, 20).g, 100, 2);
  for (const auto& [x, y] : {std::pair(4, 0), {47, 0}, {20, 30}, {47, 61}}) {
    EXPECT_EQ((*frame)->depth.at(x, y), 1250) << x << ", " << y;
  }
}

TEST_F(Record3dTest, PosesAreTurnedToLookForward) {
  const auto opened = open(files_);
  ASSERT_OK(opened);
  ASSERT_THAT((*opened)->device_poses(), SizeIs(2));
  // ARKit's camera looks along -z, up is y: what lies 1 m ahead and 0.5 m below.
  const Eigen::Vector3d ahead(0, 0.5, 1);
  EXPECT_TRUE(((*opened)->device_poses()[0].world_from_camera * ahead)
                  .isApprox(Eigen::Vector3d(1, 1.5, 2), 1e-6));
  EXPECT_TRUE(((*opened)->device_poses()[1].world_from_camera * ahead)
                  .isApprox(Eigen::Vector3d(0, 1.5, 4), 1e-6));
}

TEST_F(Record3dTest, APoseThatIsNoneLeavesItsFrameOut) {
  for (const char* quaternion : {"0, 0, 0, 0", "0, 0, 0, 1.02", "0, 0.5, 0, 0.5"}) {
    files_["metadata"] = bytes_of(fmt::format(R"({{"w": 48, "h": 64, "dw": 12, "dh": 16, "fps": 10,
      "K": [60, 0, 0, 0, 61, 0, 23.5, 31.5, 1],
      "poses": [[0, 0, 0, 1.005, 1, 2, 3], [{}, 1, 2, 3]]}})",
                                              quaternion));
    const auto opened = open(files_);
    ASSERT_OK(opened);
    EXPECT_THAT((*opened)->frames(), ElementsAre(0)) << quaternion;
    EXPECT_ERROR((*opened)->next(), "metadata: the quaternion of frame 1 has not the length 1");
    EXPECT_EQ((*opened)->next().value()->index, 0U);
  }
}

TEST_F(Record3dTest, EachFrameMayHaveACameraOfItsOwn) {
  files_["metadata"] = bytes_of(R"({"w": 48, "h": 64, "dw": 12, "dh": 16, "fps": 10,
    "K": [1, 0, 0, 0, 1, 0, 1, 1, 1],
    "perFrameIntrinsicCoeffs": [[60, 60, 23.5, 31.5], [66, 66, 23.5, 31.5]]})");
  const auto opened = open(files_);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().camera.fx, 66) << "the median";
  EXPECT_EQ((*opened)->pictures()[1].timestamp_ns, 100'000'000) << "by frames a second";
  EXPECT_TRUE((*opened)->device_poses().empty());
}

TEST_F(Record3dTest, DepthThatThePhoneDoubtsIsLeftOut) {
  Bytes confidence(kDepthWidth * kDepthHeight, 1);
  for (int y = 0; y < kDepthHeight; ++y) confidence[static_cast<std::size_t>(kDepthWidth * y)] = 0;
  files_["rgbd/0.conf"] = lzfse(confidence);
  const auto opened = open(files_);
  ASSERT_OK(opened);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->depth.at(0, 30), 0);
  EXPECT_EQ((*frame)->depth.at(30, 30), 1250);
}

TEST_F(Record3dTest, DepthLiesWhereThePhoneMeasuredIt) {
  // Of a square of 4x4 pixels in a portrait at its pixel at the right and top.
  ByteWriter metres;
  for (int i = 0; i < kDepthWidth * kDepthHeight; ++i) {
    metres.number<float>(i % kDepthWidth == 6 && i / kDepthWidth == 9 ? 1.05F : 1.0F);
  }
  files_["rgbd/0.depth"] = lzfse(metres.all());
  const auto opened = open(files_);
  ASSERT_OK(opened);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->depth.at(4 * 6 + 3, 4 * 9), 1050);
}

TEST_F(Record3dTest, WhatIsNoDepthIsZero) {
  for (const float metres : {std::nanf(""), -1.0F, 0.0F, INFINITY, 70.0F}) {
    files_["rgbd/0.depth"] = lzfse(depth_of_metres(metres));
    const auto opened = open(files_);
    ASSERT_OK(opened);
    EXPECT_EQ((*opened)->frame(0).value()->depth, image::DepthImage(48, 64));
  }
}

TEST_F(Record3dTest, AFrameWithoutDepthIsAPicture) {
  files_.erase("rgbd/0.depth");
  const auto opened = open(files_);
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), ElementsAre(1));
  EXPECT_OK((*opened)->read_color(0));
  files_.erase("rgbd/1.depth");
  EXPECT_ERROR(open(files_), "no picture has a depth image");
}

TEST_F(Record3dTest, PathsThatClimbAreRefused) {
  files_["../../outside"] = bytes_of("evil");
  EXPECT_ERROR(open(files_), "'../../outside'");
  EXPECT_TRUE(is_record3d_file(path_)) << "so that it is said";
}

TEST_F(Record3dTest, WhatGrowsBeyondItsSizeIsRefused) {
  files_["rgbd/0.depth"] = Bytes(50'000'000);  // packs into 50 KB
  const auto opened = open(files_);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "rgbd/0.depth: has more than");
}

TEST_F(Record3dTest, DamagedPartsAreNamed) {
  files_["rgbd/0.depth"] = lzfse(Bytes(100));
  files_["rgbd/1.jpg"] = bytes_of("no picture");
  const auto opened = open(files_);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "rgbd/0.depth: has 100 bytes, 12x16 pixels need 768");
  EXPECT_ERROR((*opened)->frame(1), "rgbd/1.jpg");
  files_["metadata"] = bytes_of("[]");
  EXPECT_ERROR(open(files_), "metadata: is no JSON object");
  files_["metadata"] = bytes_of(R"({"w": 48, "h": 64, "dw": 1e9, "dh": 16})");
  EXPECT_ERROR(open(files_), "'dw'");
  files_.erase("metadata");
  EXPECT_ERROR(open(files_), "metadata: is not in the archive");
  EXPECT_FALSE(is_record3d_file(path_));
}

TEST_F(Record3dTest, ASizeThatIsNotThePicturesIsRefused) {
  files_["rgbd/0.jpg"] = image::encode_jpeg(image::ColorImage(64, 48), 90);
  const auto opened = open(files_);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "64x48 pixels, metadata says 48x64");
}

TEST_F(Record3dTest, DepthOfAnotherShapeIsRefused) {
  std::string metadata(files_["metadata"].begin(), files_["metadata"].end());
  metadata.replace(metadata.find("\"dw\": 12"), 8, "\"dw\": 16");
  files_["metadata"] = bytes_of(metadata);
  EXPECT_ERROR(open(files_), "depth of 16x16 pixels is of another shape than pictures of 48x64");
}

// The same recording as the app exports it to a folder.
class Record3dExrTest : public ::testing::Test {
 protected:
  Record3dExrTest() {
    const ZipContents files = phone_files();
    write("metadata.json", files.at("metadata"));
    for (const char* number : {"0", "1"}) {
      write(fmt::format("rgb/{}.jpg", number), files.at(fmt::format("rgbd/{}.jpg", number)));
      write(fmt::format("depth/{}.exr", number), exr_file(ExrPlan()));
    }
  }
  void write(const std::string& name, const Bytes& bytes) const {
    std::filesystem::create_directories((exported_ / name).parent_path());
    EXPECT_OK(write_file(exported_ / name, bytes));
  }
  [[nodiscard]] auto open() const { return open_recording(folder_.path()); }

  const roomwise::testing::ScratchFolder folder_;
  const std::filesystem::path exported_ = folder_ / "EXR_RGBD";
};

TEST_F(Record3dExrTest, IsTheSameAsTheZip) {
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->kind(), "Record3D, EXR and JPG");
  EXPECT_OK(open_recording(exported_));
  const roomwise::testing::ScratchFolder other;
  ASSERT_TRUE(write_zip(other / "room.r3d", phone_files()));
  const auto zipped = open_record3d(other / "room.r3d", {});
  ASSERT_OK(zipped);
  EXPECT_EQ((*opened)->info().camera, (*zipped)->info().camera);
  ASSERT_THAT((*opened)->device_poses(), SizeIs(2));
  for (const std::size_t i : {0U, 1U}) {
    const auto frame = (*opened)->frame(i), same = (*zipped)->frame(i);
    ASSERT_OK(frame);
    EXPECT_EQ((*frame)->depth, (*same)->depth);
    EXPECT_EQ((*frame)->color, (*same)->color);
    EXPECT_EQ((*frame)->timestamp_ns, (*same)->timestamp_ns);
  }
}

TEST_F(Record3dExrTest, NamesTheFileThatIsDamaged) {
  write("depth/0.exr", bytes_of("no depth"));
  ExrPlan other;
  other.width = 16;
  other.height = 12;
  write("depth/1.exr", exr_file(other));
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "0.exr: it is no OpenEXR file");
  EXPECT_ERROR((*opened)->frame(1), "1.exr: has 16x12 pixels, metadata.json says 12x16");
  write("metadata.json", bytes_of("{"));
  EXPECT_ERROR(open(), "metadata.json: is no JSON object");
}

TEST_F(Record3dExrTest, APictureThatACopyLacksLeavesAGap) {
  write("metadata.json", bytes_of(R"({"w": 48, "h": 64, "dw": 12, "dh": 16, "fps": 60,
    "K": [60, 0, 0, 0, 61, 0, 23.5, 31.5, 1], "frameTimestamps": [10.5, 10.6, 10.7, 10.8]})"));
  std::filesystem::rename(exported_ / "rgb/1.jpg", exported_ / "rgb/3.jpg");
  std::filesystem::rename(exported_ / "depth/1.exr", exported_ / "depth/3.exr");
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), ElementsAre(0, 3));
  EXPECT_THAT((*opened)->notes(),
              ElementsAre(::testing::HasSubstr("2 of 4 frames have no picture")));
  EXPECT_EQ((*opened)->frame(3).value()->timestamp_ns, 10'800'000'000);
}

TEST_F(Record3dExrTest, ATimeThatIsFarTooLateCostsItsFrameAlone) {
  write("metadata.json", bytes_of(R"({"w": 48, "h": 64, "dw": 12, "dh": 16, "fps": 60,
    "K": [60, 0, 0, 0, 61, 0, 23.5, 31.5, 1], "frameTimestamps": [10.5, 900, 10.7, 10.8]})"));
  for (const char* other : {"2", "3"}) {
    std::filesystem::copy(exported_ / "rgb/1.jpg",
                          exported_ / "rgb" / fmt::format("{}.jpg", other));
    std::filesystem::copy(exported_ / "depth/1.exr",
                          exported_ / "depth" / fmt::format("{}.exr", other));
  }
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), ElementsAre(0, 2, 3));
  EXPECT_ERROR((*opened)->next(), "metadata.json: the time of frame 1 does not fit");
}

TEST_F(Record3dExrTest, AFrameWithoutDepthIsAPicture) {
  std::filesystem::remove(exported_ / "depth/0.exr");
  const auto opened = open();
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), ElementsAre(1));
  std::filesystem::remove(exported_ / "depth/1.exr");
  EXPECT_ERROR(open(), "no picture has a depth image");
}

TEST_F(Record3dTest, AFileThatWasCutOffIsRefused) {
  ASSERT_TRUE(write_zip(path_, files_));
  const Bytes whole = read_file(path_).value();
  for (std::size_t size = 0; size < whole.size(); size += 11) {
    write_quickly(path_, std::span(whole).first(size));
    EXPECT_ERROR(open_record3d(path_, {}), "room.r3d");
  }
}

}  // namespace
}  // namespace roomwise::recording
