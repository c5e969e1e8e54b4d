#include "roomwise/base/name.h"

#include <unicode/uchar.h>
#include <unicode/unistr.h>

#include <cstdint>
#include <optional>

namespace roomwise {
namespace {

// Some letters are joined or kept apart by them, as in Persian, and pictures of people joined.
bool is_joiner(UChar32 point) {
  return point == 0x200C || point == 0x200D;
}

bool is_seen(UChar32 point) {
  constexpr std::uint32_t kUnseen = U_GC_CC_MASK | U_GC_CF_MASK | U_GC_ZL_MASK | U_GC_ZP_MASK;
  return (U_GET_GC_MASK(point) & kUnseen) == 0 &&
         u_hasBinaryProperty(point, UCHAR_DEFAULT_IGNORABLE_CODE_POINT) == 0;
}

// The general categories of what is in it, as U_GC_…_MASK; nothing where it is no UTF-8 or
// something of it is not seen.
std::optional<std::uint32_t> categories_of(std::string_view text) {
  constexpr UChar32 kBroken = 0xFFFD;  // what stands for it
  const auto units =
      icu::UnicodeString::fromUTF8({text.data(), static_cast<std::int32_t>(text.size())});
  std::uint32_t categories = 0;
  for (std::int32_t at = 0; at < units.length(); at = units.moveIndex32(at, 1)) {
    const UChar32 point = units.char32At(at);
    const bool is_between = at > 0 && at + 1 < units.length();
    const bool is_picture = point == 0xFE0F && at > 0;  // an emoji, not the sign in black
    if (point == kBroken || !(is_seen(point) || is_picture || (is_joiner(point) && is_between)))
      return std::nullopt;
    categories |= U_GET_GC_MASK(point);
  }
  return categories;
}

}  // namespace

bool is_legible(std::string_view text) {
  return categories_of(text).has_value();
}

bool is_name(std::string_view text) {
  const auto categories = categories_of(text);
  return categories && (*categories & (U_GC_L_MASK | U_GC_N_MASK)) != 0;
}

}  // namespace roomwise
