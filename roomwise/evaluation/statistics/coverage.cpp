#include "roomwise/evaluation/statistics/coverage.h"

#include <cmath>

namespace roomwise::evaluation {

void Coverage::add(const Eigen::Vector3d& error_m, const Eigen::Vector3d& sigma_m) {
  for (int axis = 0; axis < 3; ++axis) {
    one_sigma.add(std::abs(error_m[axis]) <= sigma_m[axis]);
    two_sigma.add(std::abs(error_m[axis]) <= 2 * sigma_m[axis]);
  }
}

Coverage& Coverage::operator+=(const Coverage& other) {
  for (Proportion Coverage::*part : {&Coverage::one_sigma, &Coverage::two_sigma}) {
    (this->*part).successes += (other.*part).successes;
    (this->*part).n += (other.*part).n;
  }
  return *this;
}

}  // namespace roomwise::evaluation
