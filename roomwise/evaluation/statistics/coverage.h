#pragma once

#include <Eigen/Core>

#include "roomwise/evaluation/statistics/proportion.h"

namespace roomwise::evaluation {

// How often errors lie within one and two standard deviations, axis by axis: of normal errors with
// these 0.68 and 0.95.
struct Coverage {
  Proportion one_sigma, two_sigma;

  void add(const Eigen::Vector3d& error_m, const Eigen::Vector3d& sigma_m);
  Coverage& operator+=(const Coverage& other);
};

}  // namespace roomwise::evaluation
