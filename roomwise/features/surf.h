#pragma once

#include "roomwise/features/feature_extractor.h"
#include "roomwise/features/surf_descriptor.h"

namespace roomwise::features {

// The parameters of SURF under the names of the paper (Bay, Ess, Tuytelaars and Van Gool,
// "Speeded-Up Robust Features (SURF)", Computer Vision and Image Understanding 110, 2008).
struct SurfOptions {
  // Least determinant of the Hessian that makes a key-point, for intensities from 0 to 255 and box
  // filters normalised by their area; grey levels squared. Kept low, since most_keypoints then
  // takes the strongest.
  double hessian_threshold = 1;
  // Number of octaves; each doubles the step of the filter sizes. 1 to 5.
  int octaves = 4;
  // Filter sizes an octave: 4 gives 9, 15, 21, 27 px, then 15, 27, 39, 51, then 27, 51, 75, 99.
  // 3 to 8.
  int intervals = 4;
  // Distance between the places where the first octave is sampled, px; it doubles with each octave.
  int initial_step = 1;
  // Greatest ratio of the two principal curvatures (Lowe 2004, section 4.1). Not in the paper: box
  // filters take a slanted straight edge for a row of blobs, which slide along it from picture to
  // picture. At least 1; 0 keeps them, as the paper does.
  double most_edge_ratio = 8;
  // U-SURF: no orientation, every angle is 0. For cameras that are held upright.
  bool upright = false;
  // At most so many key-points a picture, the strongest; 0 keeps all.
  int most_keypoints = 1000;
  // Where the picture has more than most_keypoints, take them evenly from a grid of so many square
  // cells across the picture's longer side: first the strongest of each cell, then the second of
  // each, and so on. At most 100; 0 takes the strongest wherever they are.
  int spread_cells = 0;

  [[nodiscard]] Expected<void> validate() const;
};

// Our own SURF with 64 values. Positions are those of the scale space's maxima (no half-pixel
// shift); size_px is the side of the descriptor's window, 20 s, where s is the scale of the paper
// (1.2 for the filter of 9 px); response is the determinant of the Hessian.
class SurfExtractor final : public FeatureExtractor {
 public:
  // The options must be valid; others are a programming error (std::invalid_argument).
  explicit SurfExtractor(const SurfOptions& options);
  [[nodiscard]] Features extract(const image::GrayImage& image) const override;

 private:
  SurfOptions options_;
  SurfDescriptor descriptor_;
};

}  // namespace roomwise::features
