#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/oriented_box.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/geometry/rigid_transform.h"

// Foxglove's messages as JSON. Source: Foxglove's documentation, "Schemas". For source files only.
namespace roomwise::pipeline {

// Names of schemas, and JSON Schemas of the members that are written.
struct FoxgloveSchema {
  std::string name;
  std::string text;
};
[[nodiscard]] FoxgloveSchema foxglove_transform_schema();
[[nodiscard]] FoxgloveSchema foxglove_image_schema();
[[nodiscard]] FoxgloveSchema foxglove_calibration_schema();
[[nodiscard]] FoxgloveSchema foxglove_cloud_schema();
[[nodiscard]] FoxgloveSchema foxglove_scene_schema();
[[nodiscard]] FoxgloveSchema foxglove_log_schema();

[[nodiscard]] nlohmann::ordered_json foxglove_transform(
    TimestampNs time_ns, const std::string& parent, const std::string& child,
    const geometry::RigidTransform& parent_from_child);
// `file`: a JPEG or a PNG.
[[nodiscard]] nlohmann::ordered_json foxglove_image(TimestampNs time_ns, const std::string& frame,
                                                    std::span<const std::uint8_t> file);
[[nodiscard]] nlohmann::ordered_json foxglove_calibration(TimestampNs time_ns,
                                                          const std::string& frame,
                                                          const geometry::PinholeCamera& camera);
[[nodiscard]] nlohmann::ordered_json foxglove_cloud(TimestampNs time_ns, const std::string& frame,
                                                    const geometry::PointCloud& cloud);

// A box with its name above it. `parent_from_box`: as the box has it.
struct NamedBox {
  std::string id;
  std::string name;
  geometry::OrientedBox box;
};
[[nodiscard]] nlohmann::ordered_json foxglove_scene(TimestampNs time_ns, const std::string& frame,
                                                    std::span<const NamedBox> boxes);

// Closed lines with a name at a point.
struct NamedOutline {
  std::string id;
  std::string name;
  Eigen::Vector3d name_at = Eigen::Vector3d::Zero();
  std::vector<std::vector<Eigen::Vector3d>> rings;  // a ring's first corner is not its last
};
[[nodiscard]] nlohmann::ordered_json foxglove_outlines(TimestampNs time_ns,
                                                       const std::string& frame,
                                                       std::span<const NamedOutline> outlines);

// What `name` said, for information.
[[nodiscard]] nlohmann::ordered_json foxglove_log(TimestampNs time_ns, const std::string& name,
                                                  const std::string& message);

}  // namespace roomwise::pipeline
