#include "roomwise/fusion/frame_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using testing::half_space;
using testing::looking_at;
using testing::Picture;
using testing::render;
using testing::RigidTransform;
using testing::Scene;
using testing::small_camera;

TEST(FrameSurface, FindsThePlaneAtEveryPixelThroughAnyLens) {
  geometry::PinholeCamera bent = small_camera();
  bent.distortion = {0.26, -0.95, -0.005, 0.003, 1.16};
  const RigidTransform pose = looking_at({0, 0, 1.5}, {1.0, 0.5, 0});
  for (const geometry::PinholeCamera& camera : {small_camera(), bent}) {
    const Picture picture = render({half_space(Vector3d::UnitZ(), 0)}, pose, camera);
    const FrameSurface frame = FrameSurfaceMaker(camera).make(picture.color, picture.depth);
    const Vector3d down_camera = pose.rotation.conjugate() * -Vector3d::UnitZ();
    for (int y = 20; y < 240; y += 40) {
      for (int x = 20; x < 320; x += 40) {
        const SurfacePixel& pixel = frame.pixels.at(x, y);
        if (!pixel.has_surface()) continue;
        EXPECT_GT(pixel.normal.cast<double>().dot(down_camera), 0.9995) << x << " " << y;
        EXPECT_NEAR(pixel.distance_m(camera.unproject({x, y}, 1.0).cast<float>() *
                                     static_cast<float>(picture.depth.at(x, y) / 5000.0)),
                    0, 0.001);
      }
    }
    EXPECT_TRUE(frame.pixels.at(160, 120).has_surface());
  }
}

TEST(FrameSurface, TrustsTheNearMoreThanTheFarAndTheOutlineNotAtAll) {
  const Scene scene{testing::box({-0.3, -0.3, 1.0}, {0.3, 0.3, 1.5}),
                    half_space(-Vector3d::UnitZ(), -3.0)};
  const Picture picture = render(scene, {}, small_camera());
  const FrameSurface frame = FrameSurfaceMaker(small_camera()).make(picture.color, picture.depth);
  const SurfacePixel& near = frame.pixels.at(160, 120);
  const SurfacePixel& far = frame.pixels.at(20, 120);
  EXPECT_TRUE(near.has_surface() && far.has_surface());
  EXPECT_GT(near.weight, 5 * far.weight);
  // The box ends at x = 0.3, z = 1: 78 pixels right of the middle.
  const SurfacePixel& outline = frame.pixels.at(238, 120);
  EXPECT_FALSE(outline.has_surface());
  EXPECT_NEAR(outline.free_depth_m, 1.0F, 0.001F) << "and nothing is believed empty behind the box";
}

TEST(FrameSurface, BelievesEmptinessBeforeWhatIsTooFar) {
  const Picture picture = render({half_space(-Vector3d::UnitZ(), -7.0)}, {}, small_camera());
  const FrameSurface frame = FrameSurfaceMaker(small_camera()).make(picture.color, picture.depth);
  EXPECT_FALSE(frame.pixels.at(160, 120).has_surface());
  EXPECT_FLOAT_EQ(frame.pixels.at(160, 120).free_depth_m, 4.5F);
}

TEST(FrameSurface, KnowsNothingWhereNothingWasMeasured) {
  const Picture picture{{320, 240}, {320, 240}};
  const FrameSurface frame = FrameSurfaceMaker(small_camera()).make(picture.color, picture.depth);
  EXPECT_EQ(frame.pixels.at(160, 120).free_depth_m, 0);
  EXPECT_EQ(frame.pixels.at(160, 120).weight, 0);
}

TEST(SurfaceOptions, SayWhatIsWrong) {
  EXPECT_OK(SurfaceOptions{}.validate());
  EXPECT_ERROR(SurfaceOptions{.farthest_m = 0}.validate(), "farthest_m");
  EXPECT_ERROR(SurfaceOptions{.depth_noise_at_1m_m = 0}.validate(), "depth_noise_at_1m_m");
  EXPECT_ERROR(SurfaceOptions{.noise_floor_m = 0}.validate(), "noise_floor_m");
  EXPECT_ERROR(SurfaceOptions{.min_cosine = 1}.validate(), "min_cosine");
}

}  // namespace
}  // namespace roomwise::fusion
