#include "roomwise/features/surf_detector.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <optional>

namespace roomwise::features {
namespace {

// Box filters approximate a Gaussian of sigma 1.2 by 9 px.
constexpr float kScalePerFilterPx = 1.2F / 9;
// Balances the box approximation of the mixed derivative (section 3.2, eq. 3).
constexpr float kMixedWeight = 0.9F;

// The measures of the three box filters of one size, px from the centre. The lobes of the paper
// are `lobe` wide; a 9 px filter has lobes of 3.
struct BoxFilter {
  explicit BoxFilter(int size_px)
      : size(size_px), lobe(size_px / 3), margin(size_px / 2), half_lobe(lobe / 2) {}
  int size, lobe, margin, half_lobe;
};

struct SecondDerivatives {
  std::int32_t xx, yy, xy;
};

// Differences of the integral image's rows around row y. The three filters are sums of boxes that
// share rows, so what lies between the rows is taken once for all columns; each filter then needs
// only differences along one row.
class FilterRows {
 public:
  explicit FilterRows(int width)
      : columns_(static_cast<std::size_t>(width) + 1), values_(3 * columns_) {}

  std::uint32_t* xx() { return values_.data(); }
  std::uint32_t* yy() { return values_.data() + columns_; }
  std::uint32_t* xy() { return values_.data() + 2 * columns_; }
  [[nodiscard]] std::size_t columns() const { return columns_; }

 private:
  std::size_t columns_;
  std::vector<std::uint32_t> values_;
};

[[gnu::always_inline]] inline void difference_rows(const IntegralImage& integral,
                                                   const BoxFilter& filter, int y,
                                                   FilterRows& rows) {
  const std::uint32_t* xx_top = integral.row(y - filter.lobe + 1);
  const std::uint32_t* xx_bottom = integral.row(y + filter.lobe);
  const std::uint32_t* yy_top = integral.row(y - filter.margin);
  const std::uint32_t* yy_middle_top = integral.row(y - filter.half_lobe);
  const std::uint32_t* yy_middle_bottom = integral.row(y + filter.half_lobe + 1);
  const std::uint32_t* yy_bottom = integral.row(y + filter.margin + 1);
  const std::uint32_t* above_top = integral.row(y - filter.lobe);
  const std::uint32_t* above_bottom = integral.row(y);
  const std::uint32_t* below_top = integral.row(y + 1);
  const std::uint32_t* below_bottom = integral.row(y + filter.lobe + 1);
  std::uint32_t* __restrict xx = rows.xx();
  std::uint32_t* __restrict yy = rows.yy();
  std::uint32_t* __restrict xy = rows.xy();
  const std::size_t columns = rows.columns();
  for (std::size_t x = 0; x < columns; ++x) {
    xx[x] = xx_bottom[x] - xx_top[x];
    yy[x] = yy_bottom[x] - yy_top[x] - 3 * (yy_middle_bottom[x] - yy_middle_top[x]);
    xy[x] = (above_bottom[x] - above_top[x]) - (below_bottom[x] - below_top[x]);
  }
}

// Sums are modulo 2^32, the derivatives themselves fit: at most 2/9 of the filter's pixels times
// 255 on either side of zero.
[[gnu::always_inline]] inline SecondDerivatives derivatives_at(const std::uint32_t* xx,
                                                               const std::uint32_t* yy,
                                                               const std::uint32_t* xy,
                                                               const BoxFilter& filter, int x) {
  const std::uint32_t whole = xx[x + filter.margin + 1] - xx[x - filter.margin];
  const std::uint32_t middle = xx[x + filter.half_lobe + 1] - xx[x - filter.half_lobe];
  return {static_cast<std::int32_t>(whole - 3 * middle),
          static_cast<std::int32_t>(yy[x + filter.lobe] - yy[x - filter.lobe + 1]),
          static_cast<std::int32_t>((xy[x] - xy[x - filter.lobe]) -
                                    (xy[x + filter.lobe + 1] - xy[x + 1]))};
}

// responses[i] becomes the determinant of the Hessian at column first + i * step of row y.
[[gnu::always_inline]] inline void respond_along_row(const IntegralImage& integral,
                                                     const BoxFilter& filter, int y, int first,
                                                     int step, int count, FilterRows& rows,
                                                     float* __restrict responses) {
  difference_rows(integral, filter, y, rows);
  const std::uint32_t* xx = rows.xx();
  const std::uint32_t* yy = rows.yy();
  const std::uint32_t* xy = rows.xy();
  const float per_area = 1 / static_cast<float>(filter.size * filter.size);
  const auto determinant = [&](int x) {
    const SecondDerivatives sum = derivatives_at(xx, yy, xy, filter, x);
    const float dxx = static_cast<float>(sum.xx) * per_area;
    const float dyy = static_cast<float>(sum.yy) * per_area;
    const float dxy = static_cast<float>(sum.xy) * per_area * kMixedWeight;
    return dxx * dyy - dxy * dxy;
  };
  if (step == 1) {  // a loop of its own, since the compiler turns it into SIMD
    for (int i = 0; i < count; ++i) responses[i] = determinant(first + i);
  } else {
    for (int i = 0; i < count; ++i) responses[i] = determinant(first + i * step);
  }
}

// The same code for two kinds of processor; without fused multiplications both give the same bits.
void respond_baseline(const IntegralImage& integral, const BoxFilter& filter, int y, int first,
                      int step, int count, FilterRows& rows, float* responses) {
  respond_along_row(integral, filter, y, first, step, count, rows, responses);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void respond_avx2(const IntegralImage& integral,
                                                  const BoxFilter& filter, int y, int first,
                                                  int step, int count, FilterRows& rows,
                                                  float* responses) {
  respond_along_row(integral, filter, y, first, step, count, rows, responses);
}
#endif

auto best_respond() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return &respond_avx2;
#endif
  return &respond_baseline;
}

// The determinant sampled every `step` px with one filter. Zero where the filter leaves the
// picture: the columns and rows outside [first, end).
struct ResponseLayer {
  BoxFilter filter;
  int step;
  int columns, rows;
  int first;  // of both, in samples
  int end_column, end_row;
  std::vector<float> responses;

  [[nodiscard]] const float* row(int y) const {
    return responses.data() + static_cast<std::ptrdiff_t>(y) * columns;
  }
};

ResponseLayer empty_layer(const IntegralImage& integral, const BoxFilter& filter, int step) {
  const int columns = (integral.width() + step - 1) / step;
  const int rows = (integral.height() + step - 1) / step;
  const int first = (filter.margin + step - 1) / step;
  const auto end = [&](int extent) {
    return std::max(first, (extent - filter.margin - 1) / step + 1);
  };
  return {filter,
          step,
          columns,
          rows,
          first,
          end(integral.width()),
          end(integral.height()),
          std::vector<float>(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows))};
}

ResponseLayer compute_layer(const IntegralImage& integral, const BoxFilter& filter, int step) {
  ResponseLayer layer = empty_layer(integral, filter, step);
  const auto respond = best_respond();
  FilterRows rows(integral.width());
  for (int y = layer.first; y < layer.end_row; ++y) {
    respond(integral, filter, y * step, layer.first * step, step, layer.end_column - layer.first,
            rows,
            layer.responses.data() + static_cast<std::ptrdiff_t>(y) * layer.columns + layer.first);
  }
  return layer;
}

// Every second sample of a layer of the octave before, which has a filter of the same size.
ResponseLayer halve_layer(const IntegralImage& integral, const ResponseLayer& fine) {
  ResponseLayer layer = empty_layer(integral, fine.filter, 2 * fine.step);
  for (int y = layer.first; y < layer.end_row; ++y) {
    const float* from = fine.row(2 * y);
    float* to = layer.responses.data() + static_cast<std::ptrdiff_t>(y) * layer.columns;
    for (int x = layer.first; x < layer.end_column; ++x) to[x] = from[2 * x];
  }
  return layer;
}

using Octave = std::vector<ResponseLayer>;

// octave and interval count from 1, as in the paper.
int filter_size_px(int octave, int interval) {
  return 3 * ((1 << octave) * interval + 1);
}

Octave compute_octave(const IntegralImage& integral, const SurfOptions& options, int octave,
                      const Octave& previous) {
  Octave layers;
  const int step = options.initial_step << (octave - 1);
  for (int interval = 1; interval <= options.intervals; ++interval) {
    const bool known = octave > 1 && 2 * interval <= options.intervals;
    if (known) {
      layers.push_back(halve_layer(integral, previous[static_cast<std::size_t>(2 * interval - 1)]));
    } else {
      layers.push_back(compute_layer(integral, BoxFilter(filter_size_px(octave, interval)), step));
    }
  }
  return layers;
}

// Three layers of an octave that follow each other in scale.
struct Neighbourhood {
  const ResponseLayer& finer;
  const ResponseLayer& middle;
  const ResponseLayer& coarser;
};

// At least every neighbour, and more than those before it, so that of equal neighbours exactly one
// is taken (a blob centred between two pixels).
bool is_maximum(const Neighbourhood& layers, int x, int y) {
  const float value = layers.middle.row(y)[x];
  for (int v = y - 1; v <= y + 1; ++v) {
    const float* finer = layers.finer.row(v);
    const float* middle = layers.middle.row(v);
    const float* coarser = layers.coarser.row(v);
    for (int u = x - 1; u <= x + 1; ++u) {
      if (finer[u] >= value || coarser[u] > value) return false;
      const bool before = v < y || (v == y && u < x);
      if (before ? middle[u] >= value : middle[u] > value) return false;
    }
  }
  return true;
}

struct Refinement {
  Eigen::Vector3d offset;  // of the maximum, in samples: x, y, layers
  double value;
};

// The maximum of the quadratic through the 27 neighbours (Brown and Lowe 2002).
std::optional<Refinement> refine(const Neighbourhood& layers, int x, int y) {
  const auto value = [&](int dx, int dy, int layer) -> double {
    const ResponseLayer& from = layer < 0   ? layers.finer
                                : layer > 0 ? layers.coarser
                                            : layers.middle;
    return from.row(y + dy)[x + dx];
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
  return static_cast<float>(dxx + dyy) / static_cast<float>(filter.size * filter.size);
}

// For principal curvatures of ratio r, trace^2 / determinant is (r + 1)^2 / r (Lowe 2004, 4.1).
float most_squared_trace_over_determinant(const SurfOptions& options) {
  if (options.most_edge_ratio == 0) return std::numeric_limits<float>::infinity();
  const auto ratio = static_cast<float>(options.most_edge_ratio);
  return (ratio + 1) * (ratio + 1) / ratio;
}

void find_maxima(const IntegralImage& integral, const Neighbourhood& layers,
                 const SurfOptions& options, std::vector<Blob>& blobs) {
  const auto threshold = static_cast<float>(options.hessian_threshold);
  const float most_trace_ratio = most_squared_trace_over_determinant(options);
  const ResponseLayer& middle = layers.middle;
  const ResponseLayer& coarser = layers.coarser;
  for (int y = coarser.first + 1; y < coarser.end_row - 1; ++y) {
    const float* responses = middle.row(y);
    for (int x = coarser.first + 1; x < coarser.end_column - 1; ++x) {
      if (responses[x] < threshold || !is_maximum(layers, x, y)) continue;
      const float trace = laplacian(integral, middle.filter, x * middle.step, y * middle.step);
      if (trace * trace > most_trace_ratio * responses[x]) continue;
      const auto refined = refine(layers, x, y);
      if (!refined) continue;
      const Eigen::Vector2d place =
          (Eigen::Vector2d(x, y) + refined->offset.head<2>()) * middle.step;
      const double size =
          middle.filter.size + refined->offset.z() * (coarser.filter.size - middle.filter.size);
      blobs.push_back({place.cast<float>(), static_cast<float>(size) * kScalePerFilterPx,
                       static_cast<float>(refined->value), trace < 0});
    }
  }
}

}  // namespace

std::vector<Blob> find_blobs(const IntegralImage& integral, const SurfOptions& options) {
  std::vector<Blob> blobs;
  Octave previous;
  for (int number = 1; number <= options.octaves; ++number) {
    const int largest = filter_size_px(number, options.intervals);
    if (largest > std::min(integral.width(), integral.height())) break;
    Octave octave = compute_octave(integral, options, number, previous);
    for (std::size_t i = 1; i + 1 < octave.size(); ++i) {
      find_maxima(integral, {octave[i - 1], octave[i], octave[i + 1]}, options, blobs);
    }
    previous = std::move(octave);
  }
  return blobs;
}

}  // namespace roomwise::features
