#include "roomwise/live/eye.h"

#include <gmock/gmock.h>

#include <numbers>

#include "roomwise/base/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::live {
namespace {

TEST(CameraPlace, TheHeadingIsThatOfTheOpticalAxis) {
  // A camera that looks along y: its z is the level's y, its y points down.
  Eigen::Matrix3d level_from_camera;
  level_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  CameraPlace place;
  place.level_from_camera = {Eigen::Quaterniond(level_from_camera), {1, 2, 1.3}};
  EXPECT_NEAR(place.heading_rad(), std::numbers::pi / 2, 1e-12);
}

// ---- an eye on a home without rooms and without a map ----

service::DeviceCamera camera(bool has_depth) {
  geometry::PinholeCamera pinhole = *geometry::camera_preset("fr1");
  pinhole.width = 8;
  pinhole.height = 6;
  return {8, 6, pinhole, has_depth};
}
CameraFrame frame(double t_ms, Bytes depth = {}) {
  return {t_ms, image::encode_jpeg(image::ColorImage(8, 6), 90), std::move(depth)};
}

TEST(Eye, SaysNothingOfAHomeThatLearnedNothing) {
  Eye eye(camera(false));
  const auto glance = eye.look(frame(5), std::make_shared<HomeView>());
  ASSERT_OK(glance);
  EXPECT_EQ(glance->t_ms, 5);
  EXPECT_FALSE(glance->decision);
  EXPECT_FALSE(glance->place);
  EXPECT_FALSE(glance->picture.empty());
}

TEST(Eye, RefusesPicturesThatAreNotTheCameras) {
  const auto home = std::make_shared<HomeView>();
  EXPECT_ERROR(Eye(std::nullopt).look(frame(1), home), "no camera");
  Eye eye(camera(true));
  CameraFrame other = frame(1);
  other.color = image::encode_jpeg(image::ColorImage(9, 6), 90);
  EXPECT_ERROR(eye.look(other, home), "8 x 6");
  other.color = image::encode_jpeg(image::ColorImage(800, 600), 90);
  EXPECT_ERROR(eye.look(other, home), "more than the 96");
  other.color = {1, 2, 3};
  EXPECT_ERROR(eye.look(other, home), "neither a JPEG");
  EXPECT_ERROR(eye.look(frame(2, image::encode_png(image::DepthImage(7, 6))), home), "depth image");
  EXPECT_OK(eye.look(frame(3, image::encode_png(image::DepthImage(8, 6))), home));
  Eye without_depth(camera(false));
  EXPECT_ERROR(without_depth.look(frame(4, image::encode_png(image::DepthImage(8, 6))), home),
               "without depth");
}

}  // namespace
}  // namespace roomwise::live
