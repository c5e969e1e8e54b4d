#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "roomwise/objects/instances/instances.h"

namespace roomwise::objects::testing {

// A room of 6 x 6 m with boxes in it for things, in a frame with z up and the floor at 0, and
// key-frames that look at it: depth as the boxes give it, and a detection about each box that is
// seen.
class TestRoom {
 public:
  struct Thing {
    std::string name;
    Eigen::Vector3d center;
    Eigen::Vector3d size_m;
  };

  std::vector<Thing> things;
  DetectionSource source = DetectionSource::kDetector;  // of the detections that come

  // A key-frame at a place that looks at another; detections of what it sees, called by its name
  // or, where one is given, by that.
  void look(const Eigen::Vector3d& from, const Eigen::Vector3d& at, bool finds = true,
            const std::string& name = {}) {
    Eigen::Matrix3d axes;
    axes.col(2) = (at - from).normalized();
    axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    const auto world_from_camera = geometry::RigidTransform::from_matrix(axes, from);
    const Seen seen = draw(world_from_camera);
    ObservedKeyframe& keyframe = keyframes_.emplace_back();
    keyframe.keyframe_id = keyframes_.size() - 1;
    keyframe.world_from_camera = world_from_camera;
    keyframe.camera = camera_;
    keyframe.coarse_depth = coarse_depth(seen.depth);
    for (std::size_t i = 0; i < things.size() && finds; ++i) {
      const network::PixelBox& box = seen.boxes[i];
      if (box.area() < 200) continue;
      keyframe.detections.push_back({things[i].name, 0.7F, box,
                                     region_surface(seen.depth, camera_, box), source,
                                     name.empty() ? things[i].name : name});
    }
  }
  // Looks at a place from so many sides of a circle, from `first` on.
  void look_around(const Eigen::Vector3d& at, int looks, double radius_m = 1.8,
                   double first_rad = 0, double turn_rad = 2 * std::numbers::pi,
                   bool finds = true) {
    for (int i = 0; i < looks; ++i) {
      const double angle = first_rad + turn_rad * i / looks;
      look(at + Eigen::Vector3d(radius_m * std::cos(angle), radius_m * std::sin(angle), 1.0), at,
           finds);
    }
  }
  [[nodiscard]] std::vector<ObservedKeyframe>& keyframes() { return keyframes_; }
  // All that may be things, however little the fitted model believes of a few clean pictures.
  [[nodiscard]] std::vector<Instance> instances(double min_probability = 0) const {
    InstanceOptions options;
    options.min_probability = min_probability;
    return find_instances(keyframes_, {Eigen::Vector3d::UnitZ(), 0, true}, options);
  }
  // In the room.
  [[nodiscard]] geometry::OrientedBox box_of(const Instance& instance) const {
    return instance.box_world(keyframes_.at(instance.keyframe_id).world_from_camera);
  }

 private:
  struct Seen {
    image::DepthImage depth;
    std::vector<network::PixelBox> boxes;
  };

  // Where a ray enters a box, in lengths of its direction; infinite where it does not.
  static double entry(const Eigen::Vector3d& from, const Eigen::Vector3d& along,
                      const Thing& thing) {
    const Eigen::Array3d low = (thing.center - thing.size_m / 2 - from).array() / along.array();
    const Eigen::Array3d high = (thing.center + thing.size_m / 2 - from).array() / along.array();
    const double first = low.min(high).maxCoeff();
    return first > 0 && first <= low.max(high).minCoeff() ? first
                                                          : std::numeric_limits<double>::infinity();
  }
  // To the room's walls, floor and ceiling.
  static double to_wall(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
    const Eigen::Array3d low = (Eigen::Vector3d(-3, -3, 0) - from).array() / along.array();
    const Eigen::Array3d high = (Eigen::Vector3d(3, 3, 2.6) - from).array() / along.array();
    return low.max(high).minCoeff();
  }
  [[nodiscard]] Seen draw(const geometry::RigidTransform& world_from_camera) const {
    Seen seen{image::DepthImage(camera_.width, camera_.height), {}};
    std::vector<Eigen::AlignedBox2f> extents(things.size());
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        const Eigen::Vector3d along =
            world_from_camera.rotation * camera_.unproject(Eigen::Vector2d(x, y), 1) +
            Eigen::Vector3d::Constant(1e-9);
        double nearest = to_wall(world_from_camera.translation, along);
        std::size_t seen_thing = things.size();
        for (std::size_t i = 0; i < things.size(); ++i) {
          const double depth_m = entry(world_from_camera.translation, along, things[i]);
          if (depth_m >= nearest) continue;
          nearest = depth_m;
          seen_thing = i;
        }
        seen.depth.at(x, y) = static_cast<std::uint16_t>(std::lround(1000 * nearest));
        if (seen_thing < things.size()) {
          extents[seen_thing].extend(Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)));
        }
      }
    }
    for (const Eigen::AlignedBox2f& extent : extents) {
      network::PixelBox& box = seen.boxes.emplace_back();
      if (extent.isEmpty()) continue;
      box = {extent.min().x(), extent.min().y(), extent.max().x() + 1, extent.max().y() + 1};
    }
    return seen;
  }

  geometry::PinholeCamera camera_{.fx = 200,
                                  .fy = 200,
                                  .cx = 119.5,
                                  .cy = 89.5,
                                  .width = 240,
                                  .height = 180,
                                  .distortion = {},
                                  .depth_units_per_metre = 1000};
  std::vector<ObservedKeyframe> keyframes_;
};

}  // namespace roomwise::objects::testing
