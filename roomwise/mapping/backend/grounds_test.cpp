#include "roomwise/mapping/backend/grounds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace roomwise::mapping {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

const Vector3d kUpWorld = Vector3d::UnitZ();  // of the world
const Vector3d kWallNormal = Vector3d::UnitY();

// Four key-frames of a phone that is held on its side: its camera's y is along a wall's normal.
struct Sideways {
  Sideways() {
    Eigen::Matrix3d world_from_camera;
    world_from_camera << Vector3d::UnitZ(), -Vector3d::UnitY(), Vector3d::UnitX();
    for (std::size_t id = 0; id < 4; ++id) {
      ids.push_back(id);
      poses.push_back(
          RigidTransform::from_matrix(world_from_camera, {0.1 * static_cast<double>(id), 0, 1.4}));
      KeyframeFeatures& seen = features.emplace_back();
      for (const Vector3d& surface : {kUpWorld, kWallNormal}) {
        const Vector3d normal = world_from_camera.transpose() * surface;
        seen.normals.insert(seen.normals.end(), 100, normal.cast<float>());
      }
    }
  }
  [[nodiscard]] std::vector<Ground> measured(Grounds grounds) const {
    grounds.measure(ids, ids, features, poses, turning);
    return under(grounds);
  }
  void measure(Grounds& grounds, const std::vector<KeyframeId>& own) const {
    grounds.measure(ids, own, features, poses, turning);
  }
  [[nodiscard]] std::vector<Ground> under(const Grounds& grounds) const {
    return grounds.under(ids, poses, 10, 2);
  }

  std::vector<std::size_t> component{0, 0, 1, 1};
  std::vector<KeyframeId> ids;
  std::vector<RigidTransform> poses;
  std::vector<KeyframeFeatures> features;
  std::vector<std::optional<Vector3d>> turning{4, Vector3d::Zero()};
};

double tilt_rad(const Ground& ground) {
  return std::acos(
      std::min(1.0, (ground.world_from_ground.rotation * Vector3d::UnitZ()).dot(kUpWorld)));
}

std::vector<NodeId> keyframes_of(const std::vector<Ground>& grounds) {
  std::vector<NodeId> ids;
  for (const Ground& ground : grounds)
    for (const PoseGraphEdge& edge : ground.edges) ids.push_back(edge.to);
  return ids;
}

TEST(Grounds, UpIsWhereTheDeviceFeelsItAndNotAlongItsPicture) {
  const Sideways phone;
  Grounds grounds({}, phone.component);
  const auto along_picture = phone.measured(grounds);
  ASSERT_EQ(along_picture.size(), 2U);
  EXPECT_GT(tilt_rad(along_picture[0]), 1.5) << "the wall was taken for the floor";
  for (const KeyframeId id : phone.ids)
    grounds.add_gravity(id, phone.poses[id].rotation.conjugate() * kUpWorld);
  for (const Ground& ground : phone.measured(grounds)) EXPECT_LT(tilt_rad(ground), 1e-6);
}

TEST(Grounds, WhereNothingIsLevelUpIsAsTheDeviceFeelsIt) {
  Sideways phone;
  for (KeyframeFeatures& seen : phone.features) seen.normals.clear();
  phone.turning[1].reset();
  Grounds grounds({}, phone.component);
  for (const KeyframeId id : phone.ids)
    grounds.add_gravity(id, phone.poses[id].rotation.conjugate() * kUpWorld);
  EXPECT_EQ(keyframes_of(phone.measured(grounds)), (std::vector<NodeId>{0, 1, 2, 3}));
  for (const Ground& ground : phone.measured(grounds)) EXPECT_LT(tilt_rad(ground), 1e-6);
}

// Level surfaces are surer than what is felt, and decide; far off, that does not count at all.
TEST(Grounds, WhatIsLevelDecidesOverWhatIsFelt) {
  Sideways phone;
  phone.component = {0, 0, 0, 0};  // most of which agree
  for (const double off_rad : {0.1, 0.3}) {
    const Eigen::AngleAxisd off(off_rad, Vector3d::UnitX());
    Grounds grounds({}, phone.component);
    for (const KeyframeId id : phone.ids) {
      grounds.add_gravity(
          id, phone.poses[id].rotation.conjugate() * (id == 0 ? off * kUpWorld : kUpWorld));
    }
    grounds.measure(phone.ids, phone.ids, phone.features, phone.poses, phone.turning);
    EXPECT_EQ(grounds.contradicted(), off_rad > 0.2 ? 1U : 0U);
    const Ground ground = phone.under(grounds)[0];
    const double tilt = tilt_rad(ground);
    EXPECT_LT(tilt, 0.001);
    if (off_rad > 0.2)
      EXPECT_LT(tilt, 1e-6) << "it was dropped";
    else
      EXPECT_GT(tilt, 1e-6) << "it counts a little";
  }
}

TEST(Grounds, EachComponentHasOneWithAnEdgeToEachOfItsKeyframes) {
  const Sideways phone;
  const auto grounds = phone.measured(Grounds({}, phone.component));
  ASSERT_EQ(grounds.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(grounds[i].edges.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(grounds[i].edges[k].from, 10 + i);
      EXPECT_EQ(grounds[i].edges[k].to, 2 * i + k);
    }
  }
}

TEST(Grounds, WhereItIsNotKnownHowTheCameraTurnedNothingIsMeasured) {
  Sideways phone;
  phone.turning[0].reset();
  phone.turning[3].reset();
  const auto grounds = phone.measured(Grounds({}, phone.component));
  ASSERT_EQ(grounds.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(grounds[i].edges.size(), 1U);
    EXPECT_EQ(grounds[i].edges[0].to, 1 + i);
  }
}

TEST(Grounds, OfKeyframesThatAreNotOwnWhatTheirOwnersMeasuredStays) {
  Sideways phone;
  Grounds grounds({}, phone.component);
  phone.measure(grounds, {0, 1});
  // Those around are measured, too, as long as nobody who owns them was asked.
  EXPECT_EQ(keyframes_of(phone.under(grounds)), (std::vector<NodeId>{0, 1, 2, 3}));
  // From where 1 and 2 are own nothing is level.
  for (KeyframeFeatures& seen : phone.features) seen.normals.clear();
  phone.measure(grounds, {1, 2});
  EXPECT_EQ(keyframes_of(phone.under(grounds)), (std::vector<NodeId>{0, 3}));
  // What tells nothing to its owner tells nothing to a neighbour either.
  Sideways().measure(grounds, {0, 3});
  EXPECT_EQ(keyframes_of(phone.under(grounds)), (std::vector<NodeId>{0, 3}));
}

TEST(Grounds, WhereNothingIsLevelThereIsNone) {
  Sideways phone;
  for (KeyframeFeatures& seen : phone.features) seen.normals.clear();
  EXPECT_TRUE(phone.measured(Grounds({}, phone.component)).empty());
}

}  // namespace
}  // namespace roomwise::mapping
