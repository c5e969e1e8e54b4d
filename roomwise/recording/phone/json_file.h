#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/personal_data.h"

namespace roomwise::recording {

// The direction up in the world of pose_of_arkit(): ARKit turns it by gravity.
inline const Eigen::Vector3d kArkitUp = Eigen::Vector3d::UnitY();

// A finite number, or list of `Count` of them, that the object has under `key`; errors name the
// key.
[[nodiscard]] Expected<double> number_of(const nlohmann::json& object, const char* key);
[[nodiscard]] Expected<std::vector<double>> numbers_of(const nlohmann::json& object,
                                                       const char* key, std::size_t count);

// A pose as the first three rows of a matrix, row after row: camera to world. Fails where its
// rotation is none.
[[nodiscard]] Expected<geometry::RigidTransform> pose_of_rows(std::span<const double> rows);
// The same where the camera's axes are ARKit's and OpenGL's, x right, y up, z back: it is turned to
// Roomwise's; the world stays.
[[nodiscard]] Expected<geometry::RigidTransform> pose_of_arkit(std::span<const double> rows);

// What a frame's own JSON file says.
struct FrameFacts {
  TimestampNs timestamp_ns = 0;
  geometry::PinholeCamera camera;
  geometry::RigidTransform world_from_camera;
  image::PersonalData personal;
};
// `facts_of` reads them from the file's object. Fails, naming the file, where it has more than a
// MiB or is no JSON, and as `facts_of` does.
[[nodiscard]] Expected<FrameFacts> read_frame_facts(
    const std::filesystem::path& path, Expected<FrameFacts> (*facts_of)(const nlohmann::json&));

// The time of `seconds`; fails where it is none.
[[nodiscard]] Expected<TimestampNs> timestamp_of(double seconds);

}  // namespace roomwise::recording
