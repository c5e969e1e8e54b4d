#include "roomwise/base/timestamp.h"

#include <limits>

namespace roomwise {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr int kDecimals = 9;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

Expected<TimestampNs> parse_timestamp(std::string_view seconds) {
  const auto invalid = [&] {
    return fail("'{}' is not a time stamp; expected seconds such as 1305031229.528748", seconds);
  };
  std::string_view rest = seconds;
  const bool negative = !rest.empty() && rest.front() == '-';
  if (negative) rest.remove_prefix(1);

  constexpr std::int64_t kLargestWhole =
      std::numeric_limits<std::int64_t>::max() / kNsPerSecond - 1;
  std::int64_t whole = 0;
  std::size_t digits = 0;
  for (; digits < rest.size() && is_digit(rest[digits]); ++digits) {
    whole = whole * 10 + (rest[digits] - '0');
    if (whole > kLargestWhole) return invalid();
  }
  if (digits == 0) return invalid();
  rest.remove_prefix(digits);

  std::int64_t fraction_ns = 0;
  if (!rest.empty()) {
    if (rest.front() != '.') return invalid();
    rest.remove_prefix(1);
    std::int64_t weight_ns = kNsPerSecond / 10;
    for (const char c : rest) {
      if (!is_digit(c)) return invalid();
      fraction_ns += (c - '0') * weight_ns;
      weight_ns /= 10;
    }
  }
  const std::int64_t magnitude = whole * kNsPerSecond + fraction_ns;
  return negative ? -magnitude : magnitude;
}

std::string format_timestamp(TimestampNs timestamp_ns) {
  const bool negative = timestamp_ns < 0;
  const std::uint64_t magnitude = negative ? 0 - static_cast<std::uint64_t>(timestamp_ns)
                                           : static_cast<std::uint64_t>(timestamp_ns);
  std::string text = fmt::format("{}{}.{:0{}}", negative ? "-" : "", magnitude / kNsPerSecond,
                                 magnitude % kNsPerSecond, kDecimals);
  if (text.ends_with("000")) text.resize(text.size() - 3);
  return text;
}

}  // namespace roomwise
