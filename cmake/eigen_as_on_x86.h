#pragma once

// What Eigen does otherwise on arm64 than on x86-64, made the same, so that both give the same
// bits. Before anything of Eigen.
#if defined(__aarch64__)
// Products of large matrices ask for fused multiplications by name: a product and a sum instead.
#include <arm_neon.h>
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))

#include <Eigen/Core>

// NEON has vectors of two floats, which SSE lacks: Eigen would add three or six floats by pairs.
namespace Eigen::internal {
template <int Size>
struct find_best_packet<float, Size> {
  using type = Packet4f;
};
}  // namespace Eigen::internal
#endif
