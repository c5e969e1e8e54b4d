#include "roomwise/objects/instances/middle_variance.h"

#include <algorithm>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

// Along the axes of a box of such a size: the longer usual side along its longer level one.
Eigen::Vector3d usual_along(const Eigen::Vector3d& size_m, std::string_view name) {
  Eigen::Vector3d usual_m = usual_size_m(name);
  if (size_m.x() < size_m.y()) std::swap(usual_m.x(), usual_m.y());
  return usual_m;
}

double squared(double value) {
  return value * value;
}

}  // namespace

std::array<VarianceTerms, 3> variance_terms(const Candidate& candidate) {
  const Eigen::Vector3d& size_m = candidate.box_world.size_m;
  const Eigen::Vector3d usual_m = usual_along(size_m, candidate.class_name);
  std::array<VarianceTerms, 3> terms{};
  for (int axis = 0; axis < 3; ++axis) {
    terms[static_cast<std::size_t>(axis)] = {1, squared(candidate.jackknife_m[axis]),
                                             squared(size_m[axis]),
                                             squared(size_m[axis] - usual_m[axis])};
  }
  return terms;
}

}  // namespace roomwise::objects
