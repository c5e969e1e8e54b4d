#include "roomwise/base/name.h"

#include <unicode/uchar.h>
#include <unicode/utf8.h>

#include <cstdint>
#include <optional>

namespace roomwise {
namespace {

// The general categories of what is in it, as U_GC_…_MASK; nothing where it is no UTF-8.
std::optional<std::uint32_t> categories_of(std::string_view text) {
  std::uint32_t categories = 0;
  for (std::size_t at = 0; at < text.size();) {
    UChar32 point = 0;
    U8_NEXT(text.data(), at, text.size(), point);
    if (point < 0) return std::nullopt;
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
