#include "roomwise/live/recording/frame_images.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::live {
namespace {

using geometry::PinholeCamera;

const PinholeCamera kCamera{50, 50, 31.5, 23.5, 64, 48, {}, 1000};
const service::DeviceCamera kDevice{64, 48, kCamera, true};

// Dark to the left of the column, light from there on.
image::ColorImage edge_at(int column, int width, int height) {
  image::ColorImage picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint8_t level = x < column ? 20 : 220;
      picture.at(x, y) = {level, level, level};
    }
  }
  return picture;
}
image::DepthImage plane(int width, int height, std::uint16_t depth_mm) {
  return {width, height, depth_mm};
}
CameraFrame frame_of(const image::ColorImage& picture, const image::DepthImage& depth) {
  return {1, image::encode_png(picture), image::encode_png(depth)};
}

TEST(FrameImages, OfVersion1AreTakenAsTheyAre) {
  const auto images = images_of(frame_of(edge_at(20, 64, 48), plane(64, 48, 2000)), kDevice);
  ASSERT_OK(images);
  EXPECT_TRUE(images->color_is_as_sent);
  EXPECT_TRUE(images->depth_is_as_sent);
  EXPECT_EQ(images->depth->at(3, 4), 2000);
}

TEST(FrameImages, DepthOfAnotherSizeIsBroughtToThePicture) {
  CameraFrame frame = frame_of(edge_at(20, 64, 48), plane(16, 12, 1500));
  EXPECT_ERROR(images_of(frame, kDevice), "16 x 12 pixels, and 64 x 48 were told");
  frame.depth_size = service::ImageSize{16, 12};
  const auto images = images_of(frame, kDevice);
  ASSERT_OK(images);
  EXPECT_TRUE(images->color_is_as_sent);
  EXPECT_FALSE(images->depth_is_as_sent);
  EXPECT_EQ(images->depth->width(), 64);
  EXPECT_EQ(images->depth->at(0, 0), 1500);
  EXPECT_EQ(images->depth->at(63, 47), 1500);
}

// A lens that moved nearer sees everything a quarter larger; brought to the hello's camera, what
// was at column 40 lies at 31.5 + (40 - 31.5) / 1.25 = 38.3.
TEST(FrameImages, APictureOfAnotherFocalLengthIsBroughtToTheHellosCamera) {
  CameraFrame frame = frame_of(edge_at(40, 64, 48), plane(64, 48, 2000));
  frame.camera = kCamera;
  frame.camera->fx = frame.camera->fy = 62.5;
  const auto images = images_of(frame, kDevice);
  ASSERT_OK(images);
  EXPECT_FALSE(images->color_is_as_sent);
  EXPECT_LT(images->color.at(36, 24).r, 60);
  EXPECT_GT(images->color.at(40, 24).r, 180);
  EXPECT_EQ(images->depth->at(32, 24), 2000) << "along the axis it is as far";
  EXPECT_EQ(images->depth->at(0, 24), 0) << "out of the picture's sight";
}

TEST(FrameImages, ALensThatMovesNothingVisiblyChangesNoPixel) {
  CameraFrame frame = frame_of(edge_at(20, 64, 48), plane(64, 48, 2000));
  frame.camera = kCamera;
  frame.camera->fx += 0.1;
  EXPECT_TRUE(images_of(frame, kDevice)->color_is_as_sent);
}

TEST(FrameImages, OfAnotherSizeThanWasToldAreRefused) {
  CameraFrame frame = frame_of(edge_at(20, 60, 48), plane(64, 48, 2000));
  EXPECT_ERROR(images_of(frame, kDevice), "the picture has 60 x 48 pixels, and 64 x 48 were told");
  frame = frame_of(edge_at(20, 64, 48), plane(64, 48, 2000));
  frame.camera = kCamera;
  EXPECT_ERROR(images_of(frame, {64, 48, std::nullopt, false}), "needs fx, fy, cx and cy");
  frame.camera.reset();
  EXPECT_ERROR(images_of(frame, {64, 48, kCamera, false}), "without depth");
}

}  // namespace
}  // namespace roomwise::live
