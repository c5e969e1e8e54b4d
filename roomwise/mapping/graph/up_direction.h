#pragma once

#include <Eigen/Core>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/image.h"

namespace roomwise::mapping {

struct UpDirectionOptions {
  int grid_columns = 40;   // surface normals are measured at that many places across each image
  double max_depth_m = 5;  // farther measurements are too coarse for a normal
  double max_tilt_rad = std::numbers::pi / 4;  // between up and the cameras' mean up
  double inlier_angle_rad = 0.1;  // a level surface's normal is that near to up, or nearer
  int min_inliers = 100;          // normals
  double min_support = 0.05;      // share of all normals

  [[nodiscard]] Expected<void> validate() const;
};

// The normals of the surfaces that a depth image shows, towards the camera, in its frame, unit
// length; none where depth was not measured or does not lie in one plane. The image must have the
// camera's size.
[[nodiscard]] std::vector<Eigen::Vector3f> surface_normals(const image::DepthImage& depth,
                                                           const geometry::PinholeCamera& camera,
                                                           const UpDirectionOptions& options = {});

struct UpDirection {
  Eigen::Vector3d up_world = -Eigen::Vector3d::UnitY();  // unit length
  // The share of the measured surface normals that belong to level surfaces under this direction.
  // 0: too few did, and up_world is the mean up of the cameras (the world's -y without any).
  double support = 0;
  // Whether it began at gravity as devices felt it, and not at the cameras' mean up. Without level
  // surfaces it is up_world.
  bool is_by_gravity = false;
};

// Finds the direction up of a mapped home, whose world frame is tilted as its first camera was: the
// direction that most floors, tables and ceilings face, near to where the cameras' up points. Every
// normal votes in a plane across the mean up of the cameras; the normals about the fullest place
// are averaged. Takes one key-frame after the other and keeps only its normals; or the cameras and
// the normals of the map's surface, where there is one. Where devices feel gravity and agree, that
// is taken in the place of the cameras' up, which is far off in a phone that is held upright; level
// surfaces within `max_tilt_rad` still decide.
class UpDirectionEstimator {
 public:
  explicit UpDirectionEstimator(const UpDirectionOptions& options = {});

  // The depth image must have the camera's size.
  void add(const geometry::RigidTransform& world_from_camera, const image::DepthImage& depth,
           const geometry::PinholeCamera& camera);
  // Where the device of a key-frame feels up, unit length.
  void add_gravity(const Eigen::Vector3d& up_world) { gravity_world_.push_back(up_world); }
  void add_camera(const geometry::RigidTransform& world_from_camera);
  void add_normal(const Eigen::Vector3d& normal_world) { normals_world_.push_back(normal_world); }
  [[nodiscard]] UpDirection estimate() const;
  // The same of normals that are not kept: calls back with all of them, some at a time, each time
  // in the same order. It is asked several times.
  using VisitNormals =
      std::function<void(const std::function<void(std::span<const Eigen::Vector3d>)>&)>;
  [[nodiscard]] UpDirection estimate(const VisitNormals& visit_normals_world) const;

 private:
  UpDirectionOptions options_;
  Eigen::Vector3d camera_up_sum_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> gravity_world_;
  std::vector<Eigen::Vector3d> normals_world_;
};

}  // namespace roomwise::mapping
