#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "roomwise/base/simd.h"

namespace roomwise::features {

// The inner loops of SurfDetector: what it does along one row of a picture.

inline constexpr std::size_t kSurfLayers = 4;

// The samples [first, end) of a row.
struct SampleRange {
  int first, end;
};

using ThreeRows = std::array<const float*, 3>;  // that follow each other
using LayerRows = std::array<ThreeRows, kSurfLayers>;

// Of the two layers in the middle: the greatest response of each column around, and which
// responses are candidates for maxima.
struct CandidateRows {
  std::array<float*, 2> highest_in_column;
  std::array<std::int32_t*, 2> candidates;
};

// Rows of numbers are worked on eight at a time, so that they are read and written up to seven
// beyond their end, and have room for it.
inline constexpr std::size_t kSurfRowSlack = 8;

// The three filters are sums of boxes that share rows, so what lies between the rows is taken once
// for all columns; each filter then needs only differences along one row.
struct FilterRows {
  std::array<const std::uint32_t*, 2> xx;  // from top to bottom
  std::array<const std::uint32_t*, 4> yy, xy;
};
struct Differences {
  std::uint32_t *xx, *yy, *xy;
};

// The differences at the columns around each sample that bound the boxes, from left to right.
struct FilterColumns {
  std::array<const std::uint32_t*, 2> yy;
  std::array<const std::uint32_t*, 4> xx, xy;
};

// The same code for each kind of processor; without fused multiplications all give the same bits.
struct SurfRowKernels {
  // Columns 2 i of a row go to even[i], columns 2 i + 1 to odd[i].
  void (*split)(const std::uint32_t* row, const SampleRange&, std::uint32_t* even,
                std::uint32_t* odd);
  void (*difference)(const FilterRows&, const SampleRange&, const Differences&);
  // responses[i] becomes the determinant of the Hessian at sample i; per_area makes intensities of
  // the filters' sums.
  void (*respond)(const FilterColumns&, float per_area, const SampleRange&, float* responses);
  // Marks what may be maxima in the middle one of three rows: all bits or none of candidates[k][i]
  // for sample i of layer k + 1.
  void (*mark_candidates)(const LayerRows&, const SampleRange&, float threshold,
                          const CandidateRows&);
};
[[nodiscard]] const SurfRowKernels& surf_row_kernels(Simd simd);

}  // namespace roomwise::features
