#pragma once

#include <vector>

#include "roomwise/features/integral_image.h"
#include "roomwise/features/surf.h"

namespace roomwise::features {

// A maximum of the Hessian's determinant over place and scale.
struct Blob {
  Eigen::Vector2f position_px = Eigen::Vector2f::Zero();
  float scale = 0;      // s of the paper: 1.2 for the filter of 9 px
  float response = 0;   // the determinant there
  bool bright = false;  // lighter than what surrounds it (the Laplacian is negative)
};

// The "Fast-Hessian" detector (Bay et al., section 3): box filters in place of Gaussian second
// derivatives, maxima over 3x3x3 neighbours, refined by a quadratic (Brown and Lowe, "Invariant
// Features from Interest Point Groups", 2002). Only places where the filters lie wholly inside the
// picture are looked at. In no useful order, but always the same one.
[[nodiscard]] std::vector<Blob> find_blobs(const IntegralImage& integral,
                                           const SurfOptions& options);

}  // namespace roomwise::features
