#include "roomwise/base/simd.h"

#include <cstdlib>
#include <string_view>

namespace roomwise {

bool is_supported([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return __builtin_cpu_supports("avx2") != 0;
#endif
  return simd == Simd::kPortable;
}

Expected<Simd> simd_of_environment() {
  const char* const variable = std::getenv("ROOMWISE_SIMD");  // NOLINT: nobody sets it meanwhile
  const std::string_view name = variable == nullptr ? "" : variable;
  if (name == "portable") return Simd::kPortable;
  if (!name.empty() && name != "avx2") {
    return fail("ROOMWISE_SIMD is '{}'; it can be portable or avx2", name);
  }
  if (is_supported(Simd::kAvx2)) return Simd::kAvx2;
  if (name == "avx2") return fail("ROOMWISE_SIMD is avx2, which this processor lacks");
  return Simd::kPortable;
}

Simd process_simd() {
  static const Simd simd =
      simd_of_environment().value_or(is_supported(Simd::kAvx2) ? Simd::kAvx2 : Simd::kPortable);
  return simd;
}

}  // namespace roomwise
