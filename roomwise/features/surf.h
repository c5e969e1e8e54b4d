#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "roomwise/base/simd.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/features/surf_descriptor.h"

namespace roomwise::features {

// The parameters of SURF under the names of the paper (Bay, Ess, Tuytelaars and Van Gool,
// "Speeded-Up Robust Features (SURF)", Computer Vision and Image Understanding 110, 2008).
struct SurfOptions {
  // Least determinant of the Hessian that makes a key-point, for intensities from 0 to 255 and box
  // filters normalised by their area; grey levels squared. Kept low, since max_keypoints then
  // takes the strongest.
  double hessian_threshold = 0.3;
  // Number of octaves, each at half the size of the one before. 1 to 6.
  int octaves = 5;
  // The first octave looks at the picture at double its size, where it finds blobs half as large.
  bool doubled = true;
  // Greatest ratio of the two principal curvatures (Lowe 2004, section 4.1). Not in the paper:
  // along an edge or a bar places slide from picture to picture. At least 1; 0 keeps them, as the
  // paper does.
  double max_edge_ratio = 8;
  // U-SURF: no orientation, every angle is 0. For cameras that are held upright.
  bool upright = false;
  // At most so many key-points a picture, the strongest; 0 keeps all.
  int max_keypoints = 1000;
  // Where the picture has more than max_keypoints, take them evenly from a grid of so many square
  // cells across the picture's longer side: first the strongest of each cell, then the second of
  // each, and so on. At most 100; 0 takes the strongest wherever they are.
  int spread_cells = 0;

  [[nodiscard]] Expected<void> validate() const;
};

// Our own SURF with 64 values. Positions are those of the scale space's maxima (no half-pixel
// shift); size_px is 20 s, the side of the paper's window (ours is 24 s wide and fades), where s is
// the scale of the paper (1.2 for the filter of 9 px); response is the determinant of the Hessian.
// Beyond what it returns, extract() takes no memory once it has seen a picture of the size.
class SurfExtractor final : public FeatureExtractor {
 public:
  // The options must be valid and the processor have the instructions; others are a programming
  // error (std::invalid_argument).
  explicit SurfExtractor(const SurfOptions& options, Simd simd = process_simd());
  ~SurfExtractor() override;
  [[nodiscard]] Features extract(const image::GrayImage& image) const override;

 private:
  // The memory that one call needs. It is kept for later calls, as many as there were at once.
  struct Workspace;
  class Lease;

  SurfOptions options_;
  Simd simd_;
  SurfDescriptor descriptor_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;  // guarded by mutex_
};

}  // namespace roomwise::features
