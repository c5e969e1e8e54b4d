#include "roomwise/recording/camera_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;

class CameraFile : public ::testing::Test {
 protected:
  Expected<geometry::PinholeCamera> read(std::string_view text) {
    EXPECT_OK(write_file(path_, text));
    return read_camera(path_);
  }
  // "FOLDER/camera.txt:2"
  [[nodiscard]] std::string line(int number) const {
    return fmt::format("{}:{}", path_.string(), number);
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "camera.txt";
};

TEST_F(CameraFile, ReadsValuesCommentsAndWindowsLines) {
  const auto camera = read("# a comment\r\n\r\n  500.5  501 319.5 239.5\t640 480 1000 # more\r\n");
  ASSERT_OK(camera);
  EXPECT_EQ(camera->fx, 500.5);
  EXPECT_EQ(camera->fy, 501);
  EXPECT_EQ(camera->cx, 319.5);
  EXPECT_EQ(camera->cy, 239.5);
  EXPECT_EQ(camera->width, 640);
  EXPECT_EQ(camera->height, 480);
  EXPECT_EQ(camera->depth_units_per_metre, 1000);
  EXPECT_TRUE(camera->distortion.is_none());
}

TEST_F(CameraFile, ReadsTheLens) {
  const auto camera = read("500 501 319 239 640 480 5000 0.1 -0.2 0.003 0.004 0.5");
  ASSERT_OK(camera);
  EXPECT_EQ(camera->distortion.k1, 0.1);
  EXPECT_EQ(camera->distortion.k2, -0.2);
  EXPECT_EQ(camera->distortion.p1, 0.003);
  EXPECT_EQ(camera->distortion.p2, 0.004);
  EXPECT_EQ(camera->distortion.k3, 0.5);
}

TEST_F(CameraFile, GivesBackWhatWasWritten) {
  for (const char* preset : {"fr1", "xtion"}) {
    geometry::PinholeCamera camera = geometry::camera_preset(preset).value();
    camera.fx = 1000.0 / 3;
    ASSERT_OK(write_camera(path_, camera));
    EXPECT_EQ(read_camera(path_).value(), camera);
  }
}

TEST_F(CameraFile, NamesTheValueThatIsMissingOrWrong) {
  EXPECT_ERROR(read("# only a comment\n"), "holds no camera");
  EXPECT_ERROR(read("# c\n500 500 320\n"), line(2) + ": the value of cy is missing");
  EXPECT_ERROR(read("500 500 320 240 640 480\n"), "depth_units_per_metre is missing");
  EXPECT_ERROR(read("500 500 320 240 640 480 1000 0.1 0.2\n"), "the value of p1 is missing");
  EXPECT_ERROR(read("500 500 320 240 640 480 1000 0 0 0 0 0 7\n"), "'7' is one value too many");
  EXPECT_ERROR(read("500 abc 320 240 640 480 1000\n"), line(1) + ": fy = 'abc' is not a number");
  EXPECT_ERROR(read("500 nan 320 240 640 480 1000\n"), "fy = 'nan' is not a number");
  EXPECT_ERROR(read("500 500 320 240 640.5 480 1000\n"), "width = '640.5' is not a whole number");
  EXPECT_ERROR(read("-5 500 320 240 640 480 1000\n"), line(1) + ": focal lengths");
  EXPECT_ERROR(read("500 500 320 240 640 480 1000\n1 2\n"), line(2));
}

TEST_F(CameraFile, ResolvesAPresetOrAFile) {
  EXPECT_EQ(resolve_camera("fr2").value(), geometry::camera_preset("fr2").value());
  ASSERT_OK(read("500 501 319 239 640 480 5000"));
  EXPECT_EQ(resolve_camera(path_.string()).value().fy, 501);
  EXPECT_ERROR(resolve_camera("fr9"), "'fr9' is neither a camera preset (fr1, fr2, fr3");
}

}  // namespace
}  // namespace roomwise::recording
