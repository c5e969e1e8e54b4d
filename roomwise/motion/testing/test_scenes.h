#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/measured_features.h"
#include "roomwise/motion/rgbd_pyramid.h"

// Scenes made of formulas, and what a camera sees of them, for the tests of motion and mapping. Not
// part of the product.
namespace roomwise::motion::testing {

// What a ray meets: how many times its direction away, and how bright it is there.
struct Sight {
  double ray_lengths = 0;
  double gray = 0;
};
using Scene = std::function<Sight(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;

// Brightness that varies smoothly through space, from about 60 to 200, the same nowhere.
inline double marbled(const Eigen::Vector3d& p) {
  return 130 + 8 * std::sin(5.3 * p.x() + 2.1 * p.y() + 0.4) +
         8 * std::sin(6.1 * p.y() - 3.3 * p.z() + 1.1) +
         8 * std::sin(4.7 * p.z() + 3.9 * p.x() + 2.3) +
         25 * std::sin(20.7 * p.x() - 15.9 * p.y() + 11.1 * p.z()) +
         25 * std::sin(18.3 * p.y() + 17.1 * p.z() - 13.7 * p.x() + 0.7);
}
inline double plain(const Eigen::Vector3d&) {
  return 130;
}
using Texture = std::function<double(const Eigen::Vector3d&)>;

// The inside of a box of 3.2 x 2.2 x 3.6 m around the origin.
inline Scene box_room(Texture texture = marbled) {
  return [texture](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Vector3d half(1.6, 1.1, 1.8);
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double wall = direction[axis] > 0 ? half[axis] : -half[axis];
      if (direction[axis] != 0)
        nearest = std::min(nearest, (wall - origin[axis]) / direction[axis]);
    }
    return Sight{nearest, texture(origin + nearest * direction)};
  };
}
// The plane z = distance_m.
inline Scene wall(double distance_m, Texture texture = plain) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double length = (distance_m - origin.z()) / direction.z();
    return Sight{length, texture(origin + length * direction)};
  };
}

inline const geometry::PinholeCamera kCamera = geometry::camera_preset("fr3").value();
// What the first level of a small view of kCamera's images has.
inline geometry::PinholeCamera small_camera() {
  geometry::PinholeCamera camera = kCamera;
  camera.fx /= 4;
  camera.fy /= 4;
  camera.cx = (camera.cx - 1.5) / 4;
  camera.cy = (camera.cy - 1.5) / 4;
  camera.width /= 4;
  camera.height /= 4;
  return camera;
}

struct Picture {
  image::GrayImage gray;
  image::DepthImage depth;
};

// Through the camera's lens; what is further than the depth image can say is not measured.
inline Picture render(const Scene& scene, const geometry::PinholeCamera& camera,
                      const geometry::RigidTransform& world_from_camera) {
  Picture picture{image::GrayImage(camera.width, camera.height),
                  image::DepthImage(camera.width, camera.height)};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Sight sight = scene(world_from_camera.translation,
                                world_from_camera.rotation * camera.unproject({x, y}, 1));
      picture.gray.at(x, y) =
          static_cast<std::uint8_t>(std::lround(std::clamp(sight.gray, 0.0, 255.0)));
      const double depth = sight.ray_lengths * camera.depth_units_per_metre;
      if (depth > 0 && depth < 65535)
        picture.depth.at(x, y) = static_cast<std::uint16_t>(std::lround(depth));
    }
  }
  return picture;
}

// The small view of a picture of small_camera().
inline RgbdPyramid rgbd_pyramid(const Picture& picture) {
  return make_rgbd_pyramid(picture.gray, picture.depth, small_camera(),
                           {.shrink = 1, .levels = 3, .farthest_m = 7});
}
inline RgbdPyramid view_of(const Scene& scene, const geometry::RigidTransform& world_from_camera) {
  return rgbd_pyramid(render(scene, small_camera(), world_from_camera));
}

inline geometry::RigidTransform motion_by(const Eigen::Vector3d& turn_rad,
                                          const Eigen::Vector3d& translation_m) {
  geometry::RigidTransform turned;
  if (turn_rad.norm() > 0)
    turned.rotation = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized());
  turned.translation = translation_m;
  return turned;
}

// The same `count` points of a scene as two cameras see them, each with a descriptor of its own.
struct CommonFeatures {
  MeasuredFeatures reference;
  MeasuredFeatures current;
};
inline CommonFeatures common_features(const Scene& scene,
                                      const geometry::RigidTransform& world_from_reference,
                                      const geometry::RigidTransform& world_from_current, int count,
                                      std::uint64_t seed = 1) {
  RandomStream random(seed);
  const geometry::RigidTransform reference_from_current =
      world_from_reference.inverse() * world_from_current;
  CommonFeatures common;
  features::FloatDescriptors descriptors(count, 64);
  for (int i = 0; i < count; ++i) {
    descriptors.row(i) = Eigen::RowVectorXf::NullaryExpr(
        64, [&](Eigen::Index) { return static_cast<float>(random.normal()); });
    descriptors.row(i).normalize();
    Eigen::Vector3d current, reference;
    Eigen::Vector2d pixel_reference;
    do {
      const Eigen::Vector2d pixel(639 * random.uniform(), 479 * random.uniform());
      const Eigen::Vector3d ray = kCamera.unproject_undistorted(pixel, 1);
      current =
          ray *
          scene(world_from_current.translation, world_from_current.rotation * ray).ray_lengths;
      reference = reference_from_current * current;
      pixel_reference = reference.z() > 0.3 ? kCamera.project_undistorted(reference)
                                            : Eigen::Vector2d::Constant(-1);
    } while (!(pixel_reference.minCoeff() >= 0 && pixel_reference.x() < 639 &&
               pixel_reference.y() < 479));
    common.current.points.push_back(current);
    common.current.pixels.push_back(kCamera.project_undistorted(current));
    common.reference.points.push_back(reference);
    common.reference.pixels.push_back(pixel_reference);
    common.current.features.keypoints.emplace_back();
    common.reference.features.keypoints.emplace_back();
  }
  common.current.features.descriptors = descriptors;
  common.reference.features.descriptors = descriptors;
  return common;
}

// Where the tests' walks begin, and a step from there.
inline const geometry::RigidTransform kStart = motion_by({0.1, 0.3, 0}, {0.2, 0.1, 0.2});
inline const geometry::RigidTransform kMotion = motion_by({0.03, -0.08, 0.02}, {0.08, -0.03, 0.05});

}  // namespace roomwise::motion::testing
