#pragma once

// Eigen's products of large matrices ask for fused multiplications by name on arm64, where they do
// not on x86-64. Here these names mean a product and a sum, so that both give the same bits. Before
// anything of Eigen.
#if defined(__aarch64__)
#include <arm_neon.h>
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))
#endif
