#include "roomwise/base/name.h"

#include <unicode/uchar.h>
#include <unicode/unistr.h>

#include <cstdint>
#include <optional>

namespace roomwise {
namespace {

// The general categories of what is in it, as U_GC_…_MASK; nothing where it is no UTF-8.
std::optional<std::uint32_t> categories_of(std::string_view text) {
  constexpr UChar32 kBroken = 0xFFFD;  // what stands for it
  const auto units =
      icu::UnicodeString::fromUTF8({text.data(), static_cast<std::int32_t>(text.size())});
  std::uint32_t categories = 0;
  for (std::int32_t at = 0; at < units.length(); at = units.moveIndex32(at, 1)) {
    const UChar32 point = units.char32At(at);
    if (point == kBroken) return std::nullopt;
    categories |= U_GET_GC_MASK(point);
  }
  return categories;
}

bool is_legible(std::optional<std::uint32_t> categories) {
  constexpr std::uint32_t kUnseen = U_GC_CC_MASK | U_GC_CF_MASK | U_GC_ZL_MASK | U_GC_ZP_MASK;
  return categories && (*categories & kUnseen) == 0;
}

}  // namespace

bool is_legible(std::string_view text) {
  return is_legible(categories_of(text));
}

bool is_name(std::string_view text) {
  const auto categories = categories_of(text);
  return is_legible(categories) && (*categories & (U_GC_L_MASK | U_GC_N_MASK)) != 0;
}

}  // namespace roomwise
