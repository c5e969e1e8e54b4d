#include "roomwise/features/surf_detector.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "roomwise/features/surf_rows.h"

namespace roomwise::features {
namespace {

// Box filters approximate a Gaussian of sigma 1.2 by 9 px.
constexpr float kScalePerFilterPx = 1.2F / 9;

// The measures of the three box filters of one size, px from the centre. The lobes of the paper
// are `lobe` wide; a 9 px filter has lobes of 3.
struct BoxFilter {
  // layer counts from 0.
  constexpr explicit BoxFilter(int layer)
      : size(9 + kStep * layer), lobe(size / 3), margin(size / 2), half_lobe(lobe / 2) {}
  static constexpr int kStep = 6;  // from one layer to the next
  int size, lobe, margin, half_lobe;
};
constexpr int kLargestMargin = BoxFilter(static_cast<int>(kSurfLayers) - 1).margin;

// Rows are worked on strip by strip, so that the rows of the integral image that the filters span
// stay in the processor's nearest cache.
constexpr int kStripSamples = 160;

static_assert(IntegralImage::kTailPadding >= 2 * kSurfRowSlack);

// The box-filtered second derivatives, in the order in which their differences lie.
enum Derivative { kDxx, kDyy, kDxy };

// Three layers that follow each other in scale.
struct Neighbourhood {
  const ThreeRows& finer;
  const ThreeRows& middle;
  const ThreeRows& coarser;
};

// At least every neighbour, and more than those before it, so that of equal neighbours exactly one
// is taken (a blob centred between two pixels).
bool is_maximum(const Neighbourhood& layers, int x) {
  const float value = layers.middle[1][x];
  for (std::size_t row = 0; row < 3; ++row) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (layers.finer[row][u] >= value || layers.coarser[row][u] > value) return false;
      const bool before = row == 0 || (row == 1 && u < x);
      const float beside = layers.middle[row][u];
      if (before ? beside >= value : beside > value) return false;
    }
  }
  return true;
}

struct Refinement {
  Eigen::Vector3d offset;  // of the maximum, in samples: x, y, layers
  double value;
};

// The maximum of the quadratic through the 27 neighbours (Brown and Lowe 2002).
std::optional<Refinement> refine(const Neighbourhood& layers, int x) {
  const auto value = [&](int dx, int dy, int layer) -> double {
    const ThreeRows& from = layer < 0 ? layers.finer : layer > 0 ? layers.coarser : layers.middle;
    return static_cast<double>(from[static_cast<std::size_t>(dy + 1)][x + dx]);
  };
  const double centre = value(0, 0, 0);
  const Eigen::Vector3d gradient((value(1, 0, 0) - value(-1, 0, 0)) / 2,
                                 (value(0, 1, 0) - value(0, -1, 0)) / 2,
                                 (value(0, 0, 1) - value(0, 0, -1)) / 2);
  const double xy = (value(1, 1, 0) - value(-1, 1, 0) - value(1, -1, 0) + value(-1, -1, 0)) / 4;
  const double xs = (value(1, 0, 1) - value(-1, 0, 1) - value(1, 0, -1) + value(-1, 0, -1)) / 4;
  const double ys = (value(0, 1, 1) - value(0, -1, 1) - value(0, 1, -1) + value(0, -1, -1)) / 4;
  Eigen::Matrix3d hessian;
  hessian << value(1, 0, 0) + value(-1, 0, 0) - 2 * centre, xy, xs,  //
      xy, value(0, 1, 0) + value(0, -1, 0) - 2 * centre, ys,         //
      xs, ys, value(0, 0, 1) + value(0, 0, -1) - 2 * centre;
  Eigen::Matrix3d inverse;
  bool invertible = false;
  hessian.computeInverseWithCheck(inverse, invertible, 1e-12);
  if (!invertible) return std::nullopt;
  const Eigen::Vector3d offset = -inverse * gradient;
  // A maximum further off than the neighbours is an extrapolation, not a fit.
  if (!(offset.cwiseAbs().maxCoeff() <= 1)) return std::nullopt;
  return Refinement{offset, centre + gradient.dot(offset) / 2};
}

// The trace of the Hessian, on the scale of the responses.
float laplacian(const IntegralImage& integral, const BoxFilter& filter, int x, int y) {
  const auto box = [&](int half_width, int half_height) {
    return static_cast<std::int64_t>(
        integral.box_sum(x - half_width, y - half_height, x + half_width + 1, y + half_height + 1));
  };
  const int across = filter.lobe - 1;
  const std::int64_t dxx = box(filter.margin, across) - 3 * box(filter.half_lobe, across);
  const std::int64_t dyy = box(across, filter.margin) - 3 * box(across, filter.half_lobe);
  return static_cast<float>(dxx + dyy) /
         (SurfOctave::kIntensityScale * static_cast<float>(filter.size * filter.size));
}

// For principal curvatures of ratio r, trace^2 / determinant is (r + 1)^2 / r (Lowe 2004, 4.1).
float max_squared_trace_over_determinant(const SurfOptions& options) {
  if (options.max_edge_ratio == 0) return std::numeric_limits<float>::infinity();
  const auto ratio = static_cast<float>(options.max_edge_ratio);
  return (ratio + 1) * (ratio + 1) / ratio;
}

// The first column of a candidate from x on, or `end`.
int next_candidate(const std::int32_t* candidates, int x, int end) {
  const auto bytes = static_cast<std::size_t>(end - x) * sizeof *candidates;
  const void* found = std::memchr(candidates + x, 0xff, bytes);
  if (found == nullptr) return end;
  const auto before = static_cast<const char*>(found) - reinterpret_cast<const char*>(candidates);
  return static_cast<int>(before / static_cast<std::ptrdiff_t>(sizeof *candidates));
}

}  // namespace

// One search of an octave. Samples are `step` pixels apart in both directions: 1 or 2. Every
// second column is read by eights from rows that were split into even and odd ones.
class SurfDetector::Search {
 public:
  Search(SurfDetector& memory, const SurfOctave& octave, const SurfOptions& options, Simd simd,
         std::vector<Blob>& blobs)
      : kernels_(surf_row_kernels(simd)),
        octave_(octave),
        threshold_(static_cast<float>(options.hessian_threshold)),
        max_trace_ratio_(max_squared_trace_over_determinant(options)),
        shift_(octave.pixel_size_px < 1 ? 1 : 0),
        stride_(static_cast<std::size_t>(octave.integral.width() >> shift_) + 1 + kSurfRowSlack),
        blobs_(blobs) {
    const auto take = [&](auto& values, std::size_t rows) {
      values.resize(rows * stride_);
      return values.data();
    };
    split_ = take(memory.split_, 2 * kSplitRows);
    differences_ = take(memory.differences_, 6);
    responses_ = take(memory.responses_, 3 * kSurfLayers);
    highest_in_column_ = take(memory.highest_in_column_, 2);
    candidates_ = take(memory.candidates_, 2);
  }

  void run() {
    const auto samples = [&](int extent) { return ((extent - kLargestMargin - 1) >> shift_) + 1; };
    const int columns = samples(octave_.integral.width());
    const int rows = samples(octave_.integral.height());
    const int first = (kLargestMargin + shift_) >> shift_;
    // A maximum has neighbours on both sides, by which strips overlap.
    for (int left = first; left + 2 < columns; left += kStripSamples) {
      search_strip({left, std::min(left + kStripSamples + 2, columns)}, {first, rows});
    }
  }

 private:
  // Enough for what the largest filter spans; a power of two.
  static constexpr int kSplitRows = 32;
  static_assert(kSplitRows >= 2 * kLargestMargin + 2);

  void search_strip(const SampleRange& columns, const SampleRange& rows) {
    int split_end = (rows.first << shift_) - kLargestMargin;
    const CandidateRows candidates{{highest_in_column_, highest_in_column_ + stride_},
                                   {candidates_, candidates_ + stride_}};
    const auto responses = [&](std::size_t layer, int row) {
      return responses_ + (3 * layer + static_cast<std::size_t>(row % 3)) * stride_;
    };
    for (int row = rows.first; row < rows.end; ++row) {
      const int y = row << shift_;
      for (; shift_ > 0 && split_end <= y + kLargestMargin + 1; ++split_end) {
        kernels_.split(octave_.integral.row(split_end), reach(columns, kLargestMargin),
                       split_row(split_end, 0), split_row(split_end, 1));
      }
      LayerRows layers;
      for (std::size_t layer = 0; layer < kSurfLayers; ++layer) {
        respond(BoxFilter(static_cast<int>(layer)), y, columns, responses(layer, row));
        layers[layer] = {responses(layer, row + 1), responses(layer, row + 2),
                         responses(layer, row)};
      }
      if (row < rows.first + 2) continue;
      kernels_.mark_candidates(layers, columns, threshold_, candidates);
      find_maxima(layers, 1, row - 1, columns, candidates.candidates[0]);
      find_maxima(layers, 2, row - 1, columns, candidates.candidates[1]);
    }
  }

  std::uint32_t* split_row(int y, int odd) const {
    return split_ + static_cast<std::size_t>(2 * (y % kSplitRows) + odd) * stride_;
  }
  // The samples that filters at these reach, in split rows where rows are split.
  [[nodiscard]] SampleRange reach(const SampleRange& samples, int margin) const {
    return {samples.first + (-margin >> shift_), samples.end + ((margin + 1) >> shift_)};
  }

  void respond(const BoxFilter& filter, int y, const SampleRange& columns, float* responses) const {
    for (int odd = 0; odd <= shift_; ++odd) {
      const auto row = [&](int by) -> const std::uint32_t* {
        return shift_ > 0 ? split_row(y + by, odd) : octave_.integral.row(y + by);
      };
      const FilterRows rows{{row(1 - filter.lobe), row(filter.lobe)},
                            {row(-filter.margin), row(-filter.half_lobe), row(filter.half_lobe + 1),
                             row(filter.margin + 1)},
                            {row(-filter.lobe), row(0), row(1), row(filter.lobe + 1)}};
      kernels_.difference(rows, reach(columns, filter.margin),
                          {difference(kDxx, odd), difference(kDyy, odd), difference(kDxy, odd)});
    }
    const auto column = [&](Derivative derivative, int by) -> const std::uint32_t* {
      return difference(derivative, by & shift_) + (by >> shift_);
    };
    const FilterColumns around{
        {column(kDyy, 1 - filter.lobe), column(kDyy, filter.lobe)},
        {column(kDxx, -filter.margin), column(kDxx, -filter.half_lobe),
         column(kDxx, filter.half_lobe + 1), column(kDxx, filter.margin + 1)},
        {column(kDxy, -filter.lobe), column(kDxy, 0), column(kDxy, 1),
         column(kDxy, filter.lobe + 1)}};
    const float per_area =
        1 / (SurfOctave::kIntensityScale * static_cast<float>(filter.size * filter.size));
    kernels_.respond(around, per_area, columns, responses);
  }

  [[nodiscard]] std::uint32_t* difference(Derivative derivative, int odd) const {
    return differences_ + static_cast<std::size_t>(2 * derivative + odd) * stride_;
  }

  // Keeps the maxima among the candidates of the middle row.
  void find_maxima(const LayerRows& rows, std::size_t layer, int row, const SampleRange& columns,
                   const std::int32_t* candidates) {
    const Neighbourhood layers{rows[layer - 1], rows[layer], rows[layer + 1]};
    const BoxFilter filter(static_cast<int>(layer));
    const int end = columns.end - 1;
    for (int i = columns.first + 1; (i = next_candidate(candidates, i, end)) < end; ++i) {
      if (!is_maximum(layers, i)) continue;
      const float trace = laplacian(octave_.integral, filter, i << shift_, row << shift_);
      if (trace * trace > max_trace_ratio_ * layers.middle[1][i]) continue;
      const auto refined = refine(layers, i);
      if (!refined) continue;
      const double step = 1 << shift_;
      const double size = filter.size + refined->offset.z() * BoxFilter::kStep;
      blobs_.push_back(
          {{octave_.to_picture(static_cast<float>(step * (i + refined->offset.x()))),
            octave_.to_picture(static_cast<float>(step * (row + refined->offset.y())))},
           static_cast<float>(size) * kScalePerFilterPx * octave_.pixel_size_px,
           static_cast<float>(refined->value),
           trace < 0});
    }
  }

  const SurfRowKernels& kernels_;
  const SurfOctave& octave_;
  float threshold_, max_trace_ratio_;
  int shift_;           // log2 of the step
  std::size_t stride_;  // from one row to the next, of all that follow
  std::uint32_t *split_, *differences_;
  float *responses_, *highest_in_column_;
  std::int32_t* candidates_;
  std::vector<Blob>& blobs_;
};

void SurfDetector::find_blobs(const SurfOctave& octave, const SurfOptions& options, Simd simd,
                              std::vector<Blob>& blobs) {
  constexpr int kMinExtent = 2 * kLargestMargin + 3;
  if (std::min(octave.integral.width(), octave.integral.height()) < kMinExtent) return;
  Search(*this, octave, options, simd, blobs).run();
}

}  // namespace roomwise::features
