#pragma once

#include <Eigen/Geometry>

#include "command.h"
#include "roomwise/geometry/oriented_box.h"

// How commands write places as JSON, and words that may be missing.
namespace roomwise::app {

inline Json xyz(const Eigen::Vector3d& v) {
  return Json{v.x(), v.y(), v.z()};
}

inline Json xyzw(const Eigen::Quaterniond& q) {
  return Json{q.x(), q.y(), q.z(), q.w()};
}

// Null where it is not known.
inline Json word_or_null(const std::string& word) {
  return word.empty() ? Json(nullptr) : Json(word);
}

// Where the gravity-aligned frame lies in the map's world.
inline Json level_from_world_json(const geometry::RigidTransform& gravity_from_world) {
  return {{"translation_m", xyz(gravity_from_world.translation)},
          {"quaternion_xyzw", xyzw(gravity_from_world.rotation)}};
}

}  // namespace roomwise::app
