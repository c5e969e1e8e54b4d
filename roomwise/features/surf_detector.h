#pragma once

#include <array>
#include <vector>

#include "roomwise/features/surf.h"
#include "roomwise/features/surf_pyramid.h"

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
// Features from Interest Point Groups", 2002). Filters of 9, 15, 21 and 27 pixels run over each
// octave of the pyramid, so that the two in the middle give all sizes from 12 to 24 pixels of an
// octave and the next one goes on from there. The double size is sampled at every second pixel of
// every second row, which costs nearly nothing in what is found, the others at every pixel. Only
// places where the filters lie wholly inside the picture are looked at.
//
// Keeps its memory from one call to the next: one for each thread.
class SurfDetector {
 public:
  // Appends the blobs of one octave, in no useful order, but always the same one.
  void find_blobs(const SurfOctave& octave, const SurfOptions& options, Simd simd,
                  std::vector<Blob>& blobs);

 private:
  class Search;

  std::vector<std::uint32_t> split_;  // rows of the integral image, even and odd columns apart
  std::vector<std::uint32_t> differences_;  // along one row, of the three filters
  std::vector<float> responses_;            // of the last three rows, by layer
  std::vector<float> highest_in_column_;    // of the last three rows and of three layers
  std::vector<std::int32_t> candidates_;
};

}  // namespace roomwise::features
