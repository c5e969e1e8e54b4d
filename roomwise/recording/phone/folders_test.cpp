#include "roomwise/recording/phone/folders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;

class PhoneFolders : public ::testing::Test {
 protected:
  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    EXPECT_OK(write_file(folder_ / name, content));
  }
  [[nodiscard]] auto open() const { return open_recording(folder_.path()); }

  // Three key-frames 0.1 s apart, 1 m to the right each.
  void write_polycam(const std::string& which) const {
    for (int i = 0; i < 3; ++i) {
      const auto name = std::to_string(5'000'000 + 100'000 * i);
      nlohmann::json camera{{"fx", 50},     {"fy", 50},  {"cx", 32},  {"cy", 23},  {"width", 64},
                            {"height", 48}, {"t_00", 1}, {"t_01", 0}, {"t_02", 0}, {"t_03", i},
                            {"t_10", 0},    {"t_11", 1}, {"t_12", 0}, {"t_13", 0}, {"t_20", 0},
                            {"t_21", 0},    {"t_22", 1}, {"t_23", 0}};
      write("keyframes/" + which + "cameras/" + name + ".json", camera.dump());
      const image::ColorImage color(64, 48, which.empty() ? Rgb8{90, 90, 90} : Rgb8{40, 40, 40});
      write("keyframes/" + which + "images/" + name + ".jpg", image::encode_jpeg(color, 95));
      write("keyframes/depth/" + name + ".png", image::encode_png(image::DepthImage(16, 12, 1500)));
    }
  }
  void write_arkitscenes() const {
    for (const char* time : {"12.345", "12.445"}) {
      const std::string name = fmt::format("4242_{}", time);
      write("lowres_wide/" + name + ".png", image::encode_png(image::ColorImage(64, 48)));
      write("lowres_depth/" + name + ".png", image::encode_png(image::DepthImage(64, 48, 2000)));
      write("lowres_wide_intrinsics/" + name + ".pincam", std::string_view("64 48 50 50 32 23\n"));
    }
    write("lowres_wide.traj", std::string_view("12.3449 0 3.14159265358979 0 1 2 3\n"
                                               "12.4449 0 0 0 1 2 3\n"));
  }
  void write_seven_scenes() const {
    for (int i = 0; i < 2; ++i) {
      const std::string name = fmt::format("frame-{:06}", i);
      write(name + ".color.png", image::encode_png(image::ColorImage(640, 480)));
      image::DepthImage depth(640, 480, 2500);
      for (int x = 0; x < 320; ++x) depth.at(x, 240) = 65535;
      write(name + ".depth.png", image::encode_png(depth));
      write(name + ".pose.txt", std::string_view("0 0 1 4\n0 1 0 5\n-1 0 0 6\n0 0 0 1\n"));
    }
  }

  // Frame 1 is told to be damaged, at once; the others are given.
  void expect_without_frame_1(const char* why) const {
    const auto recording = open();
    ASSERT_OK(recording);
    EXPECT_ERROR((*recording)->next(), why);
    EXPECT_EQ((*recording)->next().value()->index, 0U);
    EXPECT_EQ((*recording)->find(1), nullptr);
  }

  ScratchFolder folder_;
};

TEST_F(PhoneFolders, PolycamsRawDataIsRead) {
  write_polycam("");
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "Polycam, raw data");
  EXPECT_EQ((*recording)->frames().size(), 3U);
  const auto frame = (*recording)->frame(2);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->timestamp_ns, 5'200'000'000);
  EXPECT_EQ((*frame)->depth.at(30, 20), 1500);
  const auto& pose = (*recording)->device_poses()[2].world_from_camera;
  EXPECT_LT((pose * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(2, 0, -1)).norm(), 1e-9);
}

TEST_F(PhoneFolders, PolycamsCorrectedPicturesAreTakenWhereThereAreSome) {
  write_polycam("");
  write_polycam("corrected_");
  EXPECT_NEAR(open().value()->read_color(0)->at(30, 20).r, 40, 2);
}

TEST_F(PhoneFolders, PolycamsDamageIsNamed) {
  write_polycam("");
  write("keyframes/cameras/5100000.json", std::string_view("{\"fx\": 50}"));
  expect_without_frame_1("5100000.json: 'fy' is missing");
  std::filesystem::remove(folder_ / "keyframes/cameras/5100000.json");
  expect_without_frame_1("5100000.jpg: has no camera of its name");
}

TEST_F(PhoneFolders, PolycamsCamerasWithoutAPictureAreTold) {
  write_polycam("");
  std::filesystem::remove(folder_ / "keyframes/images/5200000.jpg");
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->frames().size(), 2U);
  EXPECT_THAT((*recording)->notes(),
              ::testing::ElementsAre(::testing::HasSubstr("1 of 3 cameras have no picture")));
}

TEST_F(PhoneFolders, ArkitscenesIsRead) {
  write_arkitscenes();
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "ARKitScenes");
  const auto frame = (*recording)->frame(1);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->timestamp_ns, 12'445'000'000);
  EXPECT_EQ((*frame)->depth.at(30, 20), 2000);
  const auto& poses = (*recording)->device_poses();
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_LT((poses[0].world_from_camera.translation - Eigen::Vector3d(1, -2, 3)).norm(), 1e-9);
  EXPECT_LT((poses[1].world_from_camera.translation + Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
}

TEST_F(PhoneFolders, ArkitscenesPicturesWithoutIntrinsicsAreLeft) {
  write_arkitscenes();
  write("vga_wide/4242_12.345.png", image::encode_png(image::ColorImage(640, 480)));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->frame(0).value()->color.width(), 64);
  std::filesystem::remove_all(folder_ / "lowres_wide");
  EXPECT_FALSE(is_arkitscenes_folder(folder_.path()));
}

TEST_F(PhoneFolders, ArkitscenesDamageIsNamed) {
  write_arkitscenes();
  write("lowres_wide.traj", std::string_view("12 0 0\n"));
  EXPECT_ERROR(open(), "lowres_wide.traj:1: 3 values, expected 7");
  std::filesystem::remove(folder_ / "lowres_wide.traj");
  write("lowres_wide_intrinsics/4242_12.445.pincam", std::string_view("64 48 50\n"));
  expect_without_frame_1("4242_12.445.pincam: expected one line");
  std::filesystem::remove(folder_ / "lowres_wide_intrinsics/4242_12.445.pincam");
  expect_without_frame_1("4242_12.445.png: has no .pincam of its time");
}

TEST_F(PhoneFolders, ArkitscenesPathThatWasCutOffIsReadUpToThere) {
  write_arkitscenes();
  write("lowres_wide.traj", std::string_view("12.3449 0 0 0 1 2 3\n12.4449 0 0 0 1 2 3"));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->device_poses().size(), 1U) << "its last number may be cut, too";
  EXPECT_THAT((*recording)->notes(),
              ::testing::ElementsAre(::testing::HasSubstr("lowres_wide.traj:2")));
}

TEST_F(PhoneFolders, SevenScenesIsReadWithDepthOfItsOwnCamera) {
  write_seven_scenes();
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "7-Scenes");
  EXPECT_FALSE((*recording)->has_device_motion()) << "its poses are KinectFusion's";
  EXPECT_EQ((*recording)->info().camera.fx, 525);
  const auto frame = (*recording)->frame(1);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->timestamp_ns, 33'333'333);
  EXPECT_EQ((*frame)->depth.at(320, 100), 2500);
  EXPECT_EQ((*frame)->depth.at(200, 240), 0) << "65535 is no distance";
  EXPECT_EQ((*frame)->depth.at(2, 100), 0) << "its depth camera sees less";
  const auto& pose = (*recording)->device_poses()[0].world_from_camera;
  EXPECT_LT((pose * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(5, 5, 6)).norm(), 1e-9);
}

TEST_F(PhoneFolders, SevenScenesIsReadWithPicturesThatSomebodyPacked) {
  write_seven_scenes();
  for (const char* name : {"frame-000000.color", "frame-000001.color"}) {
    std::filesystem::remove(folder_ / (std::string(name) + ".png"));
    write(std::string(name) + ".jpg", image::encode_jpeg(image::ColorImage(640, 480), 90));
  }
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "7-Scenes");
  EXPECT_EQ((*recording)->frame(1).value()->depth.at(320, 100), 2500);
  write("info.txt", std::string_view("m_versionNumber = 4\n"));
  EXPECT_ERROR(open(), "no recording of a kind that is read");  // BundleFusion's
}

TEST_F(PhoneFolders, SevenScenesDamageIsNamed) {
  write_seven_scenes();
  write("frame-000001.pose.txt", std::string_view("0 0 1\n"));
  expect_without_frame_1("frame-000001.pose.txt: has 3 numbers, expected 16");
  write("frame-000001.pose.txt", std::string_view("9 0 1 4\n0 1 0 5\n-1 0 0 6\n0 0 0 1\n"));
  expect_without_frame_1("frame-000001.pose.txt: the pose is no rotation");
}

TEST_F(PhoneFolders, APictureThatIsDamagedDoesNotKeepTheOthersFromBeingRead) {
  write_polycam("");
  write("keyframes/images/5000000.jpg", std::string_view("no picture"));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_ERROR((*recording)->frame(0), "5000000.jpg");
  EXPECT_OK((*recording)->frame(1));
}

}  // namespace
}  // namespace roomwise::recording
