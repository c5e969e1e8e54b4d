#include "roomwise/fusion/gravity_aligned_frame.h"

#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using testing::box;
using testing::half_space;
using testing::looking_at;
using testing::RigidTransform;
using testing::Scene;

// A walk along a room with a table that is larger than the floor that is seen around it, in a world
// that is, as a map's is, the first camera's frame.
class GravityAlignedFrameTest : public ::testing::Test {
 protected:
  void see(const Scene& scene_room) {
    std::vector<RigidTransform> room_from_cameras;
    for (int i = 0; i < 8; ++i) {
      const double along = 0.5 * i;
      room_from_cameras.push_back(looking_at({along, -1.2, 1.5}, {along + 0.5, 0.8, 0.3}));
    }
    room_from_world_ = room_from_cameras.front();
    TsdfVolume field(TsdfOptions{});
    const FrameSurfaceMaker maker(testing::small_camera());
    for (const RigidTransform& room_from_camera : room_from_cameras) {
      const auto picture =
          testing::render(scene_room, room_from_camera, testing::small_camera(), 0.0014);
      cameras_.push_back(room_from_world_.inverse() * room_from_camera);
      ASSERT_OK(
          integrate_frame(field, maker.make(picture.color, picture.depth), cameras_.back(), pool_));
    }
    mesh_ = extract_mesh(field, MeshOptions{}, pool_).value();
  }

  ThreadPool pool_{2};
  RigidTransform room_from_world_;
  std::vector<RigidTransform> cameras_;
  PiecewiseMesh mesh_;
};

TEST_F(GravityAlignedFrameTest, StandsOnTheFloorUnderTheFirstCamera) {
  see({half_space(Vector3d::UnitZ(), 0), half_space(-Vector3d::UnitY(), -2.0),
       box({-1, 0.2, 0.70}, {5, 1.4, 0.75})});
  const GravityAlignedFrame frame = find_gravity_aligned_frame(mesh_, cameras_).value();
  EXPECT_TRUE(frame.has_floor);
  EXPECT_TRUE(frame.has_up);
  const RigidTransform gravity_from_room = frame.gravity_from_world * room_from_world_.inverse();
  EXPECT_GT((gravity_from_room.rotation * Vector3d::UnitZ()).z(), 1 - 1e-5) << "0.25 degrees";
  for (const double along : {0.0, 4.0}) {
    EXPECT_NEAR((gravity_from_room * Vector3d(along, 0, 0)).z(), 0, 0.01)
        << "the floor, not the table";
  }
  const Vector3d first = frame.gravity_from_world * Vector3d::Zero();
  EXPECT_NEAR(first.x(), 0, 1e-9);
  EXPECT_NEAR(first.y(), 0, 1e-9);
  EXPECT_NEAR(first.z(), 1.5, 0.01);
  const Vector3d looked = frame.gravity_from_world.rotation * Vector3d::UnitZ();
  EXPECT_NEAR(looked.y(), 0, 1e-9);
  EXPECT_GT(looked.x(), 0);
}

TEST_F(GravityAlignedFrameTest, ACameraThatWasHeldLowHidesNoFloor) {
  see({half_space(Vector3d::UnitZ(), 0), half_space(-Vector3d::UnitY(), -2.0)});
  for (int i = 0; i < 3; ++i)
    cameras_.insert(cameras_.end(), cameras_.begin(), cameras_.begin() + 8);
  cameras_.push_back(room_from_world_.inverse() * looking_at({0, -1.2, 0.2}, {0.5, 0.8, 0.3}));
  const GravityAlignedFrame frame = find_gravity_aligned_frame(mesh_, cameras_).value();
  EXPECT_TRUE(frame.has_floor);
  EXPECT_NEAR((frame.gravity_from_world * Vector3d::Zero()).z(), 1.5, 0.01);
}

TEST_F(GravityAlignedFrameTest, SaysThatThereIsNoFloor) {
  see({half_space(-Vector3d::UnitY(), -2.0)});
  const GravityAlignedFrame frame = find_gravity_aligned_frame(mesh_, cameras_).value();
  EXPECT_FALSE(frame.has_floor);
  EXPECT_FALSE(frame.has_up) << "a noisy wall has no level surface";
  EXPECT_NEAR((frame.gravity_from_world * Vector3d::Zero()).norm(), 0, 1e-9);
  EXPECT_FALSE(find_gravity_aligned_frame({}, {})->has_floor);
}

TEST(Transformed, MovesPlacesAndTurnsNormals) {
  const TriangleMesh mesh{{{1, 0, 0}}, {{1, 0, 0}}, {{}}, {}};
  const RigidTransform quarter_turn{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ())), {0, 0, 2}};
  const TriangleMesh moved = transformed(quarter_turn, mesh).whole().value();
  EXPECT_LT((moved.vertices[0] - Eigen::Vector3f(0, 1, 2)).norm(), 1e-6F);
  EXPECT_LT((moved.normals[0] - Eigen::Vector3f(0, 1, 0)).norm(), 1e-6F);
}

}  // namespace
}  // namespace roomwise::fusion
