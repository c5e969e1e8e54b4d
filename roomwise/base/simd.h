#pragma once

#include <cstdint>
#include <cstring>

#include "roomwise/base/expected.h"

namespace roomwise {

// Instructions to compute with. Each kind gives the same bits. Portable is what the compiler makes
// of the code for every processor of an architecture.
enum class Simd { kPortable, kAvx2, kNeon };

// Whether this processor has them.
[[nodiscard]] bool is_supported(Simd simd);

// The best that this processor has.
[[nodiscard]] Simd best_simd();

// The instructions of this process: what the environment's ROOMWISE_SIMD names ("portable", "avx2"
// or "neon"), or the best that the processor has. An error where it names others, or ones that the
// processor lacks.
[[nodiscard]] Expected<Simd> simd_of_environment();

// The same for all code of the process, looked up once; where the environment is wrong, the best.
[[nodiscard]] Simd process_simd();

// Eight numbers at a time, as GCC and Clang translate them for any processor. Handed over by
// reference, since by value they would travel differently with and without AVX.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using UInt8 = std::uint32_t __attribute__((vector_size(32)));  // for sums modulo 2^32

// Four at a time: what a register of NEON holds. Wider ones the compiler would take apart, and by
// single numbers where they are compared or shuffled.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using UInt4 = std::uint32_t __attribute__((vector_size(16)));

// The numbers that code for these instructions works on at a time.
template <Simd simd>
struct Lanes {
  static constexpr int kCount = 8;
  using Float = Float8;
  using Int = Int8;
  using UInt = UInt8;
  using UShort = std::uint16_t __attribute__((vector_size(16)));
};
template <>
struct Lanes<Simd::kNeon> {
  static constexpr int kCount = 4;
  using Float = Float4;
  using Int = Int4;
  using UInt = UInt4;
  using UShort = std::uint16_t __attribute__((vector_size(8)));
};

// As many numbers as the vector has, from or to any address.
template <typename Number, typename Vector>
[[gnu::always_inline]] inline void load(const Number* from, Vector& to) {
  static_assert(sizeof to % sizeof *from == 0 && sizeof to[0] == sizeof *from);
  std::memcpy(&to, from, sizeof to);
}
template <typename Number, typename Vector>
[[gnu::always_inline]] inline void store(const Vector& from, Number* to) {
  static_assert(sizeof from % sizeof *to == 0 && sizeof from[0] == sizeof *to);
  std::memcpy(to, &from, sizeof from);
}

}  // namespace roomwise
