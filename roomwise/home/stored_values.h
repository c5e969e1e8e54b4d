#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/home/database.h"

// How values of the library stand in columns (schema.cpp says the same for people). Private to
// home/.
namespace roomwise::home {

// tx_m, ty_m, tz_m, qx, qy, qz, qw.
using PoseNumbers = std::array<double, 7>;

inline PoseNumbers to_numbers(const geometry::RigidTransform& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

// The pose in the seven columns from `first` on. Not normalised anew: it comes back as it was.
inline geometry::RigidTransform pose_column(const Statement& row, int first) {
  const PoseNumbers n = row.columns<7>(first);
  return {Eigen::Quaterniond(n[6], n[3], n[4], n[5]), Eigen::Vector3d(n[0], n[1], n[2])};
}

static_assert(std::endian::native == std::endian::little, "float blobs are little-endian");

inline Bytes to_blob(std::span<const float> values) {
  Bytes bytes(values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::vector<float> to_floats(std::span<const std::uint8_t> bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

}  // namespace roomwise::home
