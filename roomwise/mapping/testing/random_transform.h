#pragma once

#include "roomwise/base/random.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::mapping::testing {

// A transform whose turn and shift are normal with these standard deviations along each axis.
inline geometry::RigidTransform random_transform(RandomStream& random, double translation_m,
                                                 double rotation_rad) {
  geometry::Vector6d twist;
  for (double& value : twist.head<3>()) value = rotation_rad * random.normal();
  for (double& value : twist.tail<3>()) value = translation_m * random.normal();
  return geometry::RigidTransform::exp(twist);
}

}  // namespace roomwise::mapping::testing
