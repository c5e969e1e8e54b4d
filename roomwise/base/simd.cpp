#include "roomwise/base/simd.h"

#include <array>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace roomwise {
namespace {

constexpr std::array<std::pair<std::string_view, Simd>, 3> kNames{
    {{"portable", Simd::kPortable}, {"avx2", Simd::kAvx2}, {"neon", Simd::kNeon}}};

}  // namespace

bool is_supported(Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return __builtin_cpu_supports("avx2") != 0;
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) return true;  // part of the architecture
#endif
  return simd == Simd::kPortable;
}

Simd best_simd() {
  for (const Simd simd : {Simd::kAvx2, Simd::kNeon}) {
    if (is_supported(simd)) return simd;
  }
  return Simd::kPortable;
}

Expected<Simd> simd_of_environment() {
  const char* const variable = std::getenv("ROOMWISE_SIMD");  // NOLINT: nobody sets it meanwhile
  const std::string_view name = variable == nullptr ? "" : variable;
  if (name.empty()) return best_simd();
  for (const auto& [known, simd] : kNames) {
    if (name != known) continue;
    if (!is_supported(simd)) return fail("ROOMWISE_SIMD is {}, which this processor lacks", name);
    return simd;
  }
  return fail("ROOMWISE_SIMD is '{}'; it can be portable, avx2 or neon", name);
}

Simd process_simd() {
  static const Simd simd = simd_of_environment().value_or(best_simd());
  return simd;
}

}  // namespace roomwise
