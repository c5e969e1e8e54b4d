#pragma once

#include <cstdint>
#include <cstring>

#include "roomwise/base/expected.h"

namespace roomwise {

// Instructions to compute with. Each kind gives the same bits.
enum class Simd { kPortable, kAvx2 };

// Whether this processor has them.
[[nodiscard]] bool is_supported(Simd simd);

// The instructions of this process: what the environment's ROOMWISE_SIMD names ("portable" or
// "avx2"), or the best that the processor has. An error where it names others, or ones that the
// processor lacks.
[[nodiscard]] Expected<Simd> simd_of_environment();

// The same for all code of the process, looked up once; where the environment is wrong, the best.
[[nodiscard]] Simd process_simd();

// Eight numbers at a time, as GCC and Clang translate them for any processor. Handed over by
// reference, since by value they would travel differently with and without AVX.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using UInt8 = std::uint32_t __attribute__((vector_size(32)));  // for sums modulo 2^32

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

}  // namespace roomwise
