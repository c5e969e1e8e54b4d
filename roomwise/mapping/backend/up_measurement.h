#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// How well a key-frame's surfaces tell which way is up. The defaults were fitted to recordings with
// truth (bench/up_direction_fit).
struct UpMeasurementOptions {
  double inlier_angle_rad = 0.1;   // a level surface's normal is that near to up, or nearer; a
                                   // wall's is as near to level
  double normal_sigma_rad = 0.03;  // of one surface normal, with what neighbours err alike
  double systematic_sigma_rad = 0.0005;  // what all normals of a picture err alike
  double delay_s = 0.028;  // depth may be older or newer than the picture by about that

  [[nodiscard]] Expected<void> validate() const;
};

// Which way is up, by the surfaces that one key-frame sees (floors, tables and ceilings face up or
// down, walls stand along it), or as its device's accelerometer felt it.
struct UpMeasurement {
  Eigen::Vector3d up_camera = -Eigen::Vector3d::UnitY();  // unit length
  // Inverse covariance of small turns about the camera's axes, rad^-2; none about up.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

// The direction about `expected_up_camera` that the normals (camera frame, unit length) bear out
// best; nothing where they tell nothing of it. `turning_rad_s` is how the camera turned, in its
// frame: where depth lags behind the picture, up is off by as much, about the same axis. A turn
// about up moves nothing.
[[nodiscard]] std::optional<UpMeasurement> measure_up(
    std::span<const Eigen::Vector3f> normals_camera, const Eigen::Vector3d& expected_up_camera,
    const Eigen::Vector3d& turning_rad_s, const UpMeasurementOptions& options = {});

// Up as the device of a key-frame felt it, unit length (geometry::kUpSigma_rad).
[[nodiscard]] UpMeasurement felt_up(const Eigen::Vector3d& up_camera);

// Whether two measurements of one key-frame are further apart than once in a thousand times.
[[nodiscard]] bool contradict(const UpMeasurement& one, const UpMeasurement& other);

// What two measurements say together, by how sure each is. They must not contradict each other.
[[nodiscard]] UpMeasurement together(const UpMeasurement& one, const UpMeasurement& other);

// The measurement as an edge from the ground, a node whose z axis is up, to the key-frame: it holds
// the key-frame's tilt and leaves it free to turn about up and to be anywhere. It is made at the
// poses given, where it weighs as Cauchy's kernel of so many sigmas says.
[[nodiscard]] PoseGraphEdge up_edge(NodeId ground,
                                    const geometry::RigidTransform& world_from_ground,
                                    NodeId keyframe,
                                    const geometry::RigidTransform& world_from_keyframe,
                                    const UpMeasurement& measurement, double kernel_sigmas);

}  // namespace roomwise::mapping
