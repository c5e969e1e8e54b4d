#include "roomwise/features/surf_rows.h"

namespace roomwise::features {
namespace {

template <Simd simd>
constexpr int kCount = Lanes<simd>::kCount;
template <Simd simd>
using Float = typename Lanes<simd>::Float;
template <Simd simd>
using Int = typename Lanes<simd>::Int;
template <Simd simd>
using UInt = typename Lanes<simd>::UInt;

// Columns 2 i of a row go to even[i], columns 2 i + 1 to odd[i].
template <Simd simd>
[[gnu::always_inline]] inline void split_row(const std::uint32_t* row, const SampleRange& samples,
                                             std::uint32_t* even, std::uint32_t* odd) {
  for (int i = samples.first; i < samples.end; i += kCount<simd>) {
    UInt<simd> a, b;
    load(row + 2 * i, a);
    load(row + 2 * i + kCount<simd>, b);
    if constexpr (kCount<simd> == 8) {
      store(__builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14), even + i);
      store(__builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15), odd + i);
    } else {
      store(__builtin_shufflevector(a, b, 0, 2, 4, 6), even + i);
      store(__builtin_shufflevector(a, b, 1, 3, 5, 7), odd + i);
    }
  }
}

template <Simd simd>
[[gnu::always_inline]] inline void difference_rows(const FilterRows& from,
                                                   const SampleRange& samples,
                                                   const Differences& to) {
  const FilterRows rows = from;
  const Differences target = to;
  for (int i = samples.first; i < samples.end; i += kCount<simd>) {
    UInt<simd> a, b, c, d;
    load(rows.xx[0] + i, a);
    load(rows.xx[1] + i, b);
    store(b - a, target.xx + i);
    load(rows.yy[0] + i, a);
    load(rows.yy[1] + i, b);
    load(rows.yy[2] + i, c);
    load(rows.yy[3] + i, d);
    const UInt<simd> middle = c - b;
    store(d - a - (middle + middle + middle), target.yy + i);
    load(rows.xy[0] + i, a);
    load(rows.xy[1] + i, b);
    load(rows.xy[2] + i, c);
    load(rows.xy[3] + i, d);
    store((b - a) - (d - c), target.xy + i);
  }
}

// responses[i] becomes the determinant of the Hessian at sample i. Sums are modulo 2^32, the
// derivatives themselves fit: at most 2/9 of the filter's pixels times 255 * kIntensityScale on
// either side of zero.
template <Simd simd>
[[gnu::always_inline]] inline void respond_along_row(const FilterColumns& from, float per_area,
                                                     const SampleRange& samples, float* responses) {
  const FilterColumns columns = from;
  const float per_squared_area = per_area * per_area;
  for (int i = samples.first; i < samples.end; i += kCount<simd>) {
    UInt<simd> a, b, c, d;
    load(columns.xx[0] + i, a);
    load(columns.xx[1] + i, b);
    load(columns.xx[2] + i, c);
    load(columns.xx[3] + i, d);
    const UInt<simd> middle = c - b;
    const Float<simd> dxx =
        __builtin_convertvector((Int<simd>)(d - a - (middle + middle + middle)), Float<simd>);
    load(columns.yy[0] + i, a);
    load(columns.yy[1] + i, b);
    const Float<simd> dyy = __builtin_convertvector((Int<simd>)(b - a), Float<simd>);
    load(columns.xy[0] + i, a);
    load(columns.xy[1] + i, b);
    load(columns.xy[2] + i, c);
    load(columns.xy[3] + i, d);
    const Float<simd> dxy = __builtin_convertvector((Int<simd>)((b - a) - (d - c)), Float<simd>);
    const Float<simd> determinant = (dxx * dyy - dxy * dxy) * per_squared_area;
    store(determinant, responses + i);
  }
}

// The greatest of three rows at some samples.
template <Simd simd>
[[gnu::always_inline]] inline void find_highest(const ThreeRows& rows, int x,
                                                Float<simd>& highest) {
  Float<simd> a, b, c;
  load(rows[0] + x, a);
  load(rows[1] + x, b);
  load(rows[2] + x, c);
  const Float<simd> ab = a > b ? a : b;
  highest = ab > c ? ab : c;
}

// Whether the responses at some samples are at least the threshold and all of `columns`, the
// greatest of each column, to either side; marked by all bits or none.
template <Simd simd>
[[gnu::always_inline]] inline void mark_candidates(const float* responses, const float* columns,
                                                   float threshold, std::int32_t* candidates) {
  Float<simd> here, left, middle, right;
  load(responses, here);
  load(columns - 1, left);
  load(columns, middle);
  load(columns + 1, right);
  const Int<simd> is_candidate =
      (here >= threshold) & (here >= left) & (here >= middle) & (here >= right);
  store(is_candidate, candidates);
}

// Marks what may be maxima in the middle one of three rows.
template <Simd simd>
[[gnu::always_inline]] inline void mark_candidates_along_row(const LayerRows& rows,
                                                             const SampleRange& samples,
                                                             float threshold,
                                                             const CandidateRows& to) {
  for (int x = samples.first; x < samples.end; x += kCount<simd>) {
    Float<simd> finest, fine, coarse, coarsest;
    find_highest<simd>(rows[0], x, finest);
    find_highest<simd>(rows[1], x, fine);
    find_highest<simd>(rows[2], x, coarse);
    find_highest<simd>(rows[3], x, coarsest);
    const Float<simd> both = fine > coarse ? fine : coarse;
    const Float<simd> lower = finest > both ? finest : both;
    const Float<simd> upper = coarsest > both ? coarsest : both;
    store(lower, to.highest_in_column[0] + x);
    store(upper, to.highest_in_column[1] + x);
  }
  for (int x = samples.first + 1; x < samples.end - 1; x += kCount<simd>) {
    mark_candidates<simd>(rows[1][1] + x, to.highest_in_column[0] + x, threshold,
                          to.candidates[0] + x);
    mark_candidates<simd>(rows[2][1] + x, to.highest_in_column[1] + x, threshold,
                          to.candidates[1] + x);
  }
}

#define ROOMWISE_KERNELS(name, simd, target)                                            \
  constexpr SurfRowKernels name {                                                       \
    [](const std::uint32_t* row, const SampleRange& samples, std::uint32_t* even,       \
       std::uint32_t* odd) target { split_row<simd>(row, samples, even, odd); },        \
        [](const FilterRows& rows, const SampleRange& samples, const Differences& to)   \
            target { difference_rows<simd>(rows, samples, to); },                       \
        [](const FilterColumns& columns, float per_area, const SampleRange& samples,    \
           float* responses)                                                            \
            target { respond_along_row<simd>(columns, per_area, samples, responses); }, \
        [](const LayerRows& rows, const SampleRange& samples, float threshold,          \
           const CandidateRows& to)                                                     \
            target { mark_candidates_along_row<simd>(rows, samples, threshold, to); }   \
  }
ROOMWISE_KERNELS(kPortableRows, Simd::kPortable, );
#if defined(__x86_64__)
ROOMWISE_KERNELS(kAvx2Rows, Simd::kAvx2, __attribute__((target("avx2"))));
#elif defined(__aarch64__)
ROOMWISE_KERNELS(kNeonRows, Simd::kNeon, );
#endif
#undef ROOMWISE_KERNELS

}  // namespace

const SurfRowKernels& surf_row_kernels([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return kAvx2Rows;
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) return kNeonRows;
#endif
  return kPortableRows;
}

}  // namespace roomwise::features
