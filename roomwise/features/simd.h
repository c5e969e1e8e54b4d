#pragma once

#include <cstdint>
#include <cstring>

namespace roomwise::features {

// Instructions to compute with. Each kind gives the same bits.
enum class Simd { kPortable, kAvx2 };

// Whether this processor has them.
[[nodiscard]] inline bool is_supported([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return __builtin_cpu_supports("avx2") != 0;
#endif
  return simd == Simd::kPortable;
}

[[nodiscard]] inline Simd best_simd() {
  return is_supported(Simd::kAvx2) ? Simd::kAvx2 : Simd::kPortable;
}

// Eight numbers at a time, as GCC and Clang translate them for any processor. Handed over by
// reference, since by value they would travel differently with and without AVX.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));

// Eight numbers from or to any address.
template <typename Number, typename Vector>
[[gnu::always_inline]] inline void load(const Number* from, Vector& to) {
  static_assert(sizeof to == 8 * sizeof *from);
  std::memcpy(&to, from, sizeof to);
}
template <typename Number, typename Vector>
[[gnu::always_inline]] inline void store(const Vector& from, Number* to) {
  static_assert(sizeof from == 8 * sizeof *to);
  std::memcpy(to, &from, sizeof from);
}

}  // namespace roomwise::features
