#include "roomwise/network/formats/number_formats.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace roomwise::network {
namespace {

using Span = std::span<const std::uint8_t>;

float float_from_half(std::uint16_t half) {
  const float sign = (half & 0x8000) != 0 ? -1.0F : 1.0F;
  const int exponent = (half >> 10) & 31;
  const auto fraction = static_cast<float>(half & 1023);
  if (exponent == 31) {
    return sign *
           (fraction > 0 ? std::bit_cast<float>(0x7FC00000) : std::bit_cast<float>(0x7F800000));
  }
  const float significand = exponent == 0 ? fraction / 1024 : 1 + fraction / 1024;
  return sign * std::ldexp(significand, exponent == 0 ? -14 : exponent - 15);
}

// The upper half of a float's bits.
float float_from_brain_float(std::uint16_t bits) {
  return std::bit_cast<float>(std::uint32_t{bits} << 16);
}

template <typename Number, typename Result, typename Convert>
void convert(Span bytes, std::vector<Result>& results, const Convert& convert_one) {
  results.resize(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i < results.size(); ++i) {
    Number number;
    std::memcpy(&number, bytes.data() + i * sizeof(Number), sizeof(Number));
    results[i] = convert_one(number);
  }
}

}  // namespace

std::span<const NumberFormatNames> number_formats() {
  static constexpr std::array kFormats{
      NumberFormatNames{NumberFormat::kFloat, 4, "torch.FloatStorage", "F32"},
      NumberFormatNames{NumberFormat::kHalf, 2, "torch.HalfStorage", "F16"},
      NumberFormatNames{NumberFormat::kBfloat16, 2, "torch.BFloat16Storage", "BF16"},
      NumberFormatNames{NumberFormat::kDouble, 8, "torch.DoubleStorage", "F64"},
      NumberFormatNames{NumberFormat::kInteger64, 8, "torch.LongStorage", "I64"},
      NumberFormatNames{NumberFormat::kInteger32, 4, "torch.IntStorage", "I32"},
      NumberFormatNames{NumberFormat::kBool, 1, "torch.BoolStorage", ""},
  };
  return kFormats;
}

std::size_t bytes_of(NumberFormat format) {
  return std::ranges::find(number_formats(), format, &NumberFormatNames::format)->bytes;
}

bool is_integer(NumberFormat format) {
  return format == NumberFormat::kInteger32 || format == NumberFormat::kInteger64 ||
         format == NumberFormat::kBool;
}

Constant numbers_from(NumberFormat format, Span bytes) {
  const auto same = [](auto value) { return value; };
  Constant constant;
  switch (format) {
    case NumberFormat::kFloat:
      convert<float>(bytes, constant.floats, same);
      break;
    case NumberFormat::kHalf:
      convert<std::uint16_t>(bytes, constant.floats, float_from_half);
      break;
    case NumberFormat::kBfloat16:
      convert<std::uint16_t>(bytes, constant.floats, float_from_brain_float);
      break;
    case NumberFormat::kDouble:
      convert<double>(bytes, constant.floats, [](double x) { return static_cast<float>(x); });
      break;
    case NumberFormat::kInteger32:
      convert<std::int32_t>(bytes, constant.integers, same);
      break;
    case NumberFormat::kInteger64:
      convert<std::int64_t>(bytes, constant.integers, same);
      break;
    case NumberFormat::kBool:
      convert<std::uint8_t>(bytes, constant.integers, same);
      break;
  }
  constant.is_integer = is_integer(format);
  return constant;
}

std::optional<std::size_t> values_of(const Shape& shape) {
  constexpr std::int64_t kMaxValues = std::int64_t{1} << 30;
  std::int64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0 || size > kMaxValues || (size > 0 && count > kMaxValues / size))
      return std::nullopt;
    count *= size;
  }
  return static_cast<std::size_t>(count);
}

}  // namespace roomwise::network
