#include "roomwise/image/exif.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace roomwise::image {
namespace {

// Reads the numbers of a TIFF structure in its byte order, and nothing outside it.
class TiffReader {
 public:
  TiffReader(std::span<const std::uint8_t> tiff, bool big_endian)
      : tiff_(tiff), big_endian_(big_endian) {}

  [[nodiscard]] std::optional<std::uint32_t> u16(std::size_t at) const { return number(at, 2); }
  [[nodiscard]] std::optional<std::uint32_t> u32(std::size_t at) const { return number(at, 4); }

 private:
  [[nodiscard]] std::optional<std::uint32_t> number(std::size_t at, std::size_t size) const {
    if (at > tiff_.size() || tiff_.size() - at < size) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      value = value << 8 | tiff_[at + (big_endian_ ? i : size - 1 - i)];
    }
    return value;
  }

  std::span<const std::uint8_t> tiff_;
  bool big_endian_;
};

// The value of the first directory's Orientation entry.
std::optional<std::uint32_t> find_orientation(const TiffReader& tiff) {
  constexpr std::uint32_t kMagic = 42;
  constexpr std::uint32_t kOrientation = 0x0112;
  constexpr std::uint32_t kShort = 3;
  constexpr std::size_t kEntrySize = 12;

  if (tiff.u16(2) != kMagic) return std::nullopt;
  const auto directory = tiff.u32(4);
  if (!directory) return std::nullopt;
  const std::size_t start = *directory;
  const std::uint32_t entries = tiff.u16(start).value_or(0);
  for (std::uint32_t i = 0; i < entries; ++i) {
    const std::size_t entry = start + 2 + i * kEntrySize;
    const auto tag = tiff.u16(entry);
    if (!tag) return std::nullopt;  // the directory runs past the end
    if (*tag == kOrientation && tiff.u16(entry + 2) == kShort) return tiff.u16(entry + 8);
  }
  return std::nullopt;
}

}  // namespace

int exif_orientation(std::span<const std::uint8_t> app1) {
  constexpr std::array<std::uint8_t, 6> kExif{'E', 'x', 'i', 'f', 0, 0};
  if (app1.size() < kExif.size() + 2 || !std::ranges::equal(app1.first(kExif.size()), kExif)) {
    return kUpright;
  }
  const auto tiff = app1.subspan(kExif.size());
  const bool big_endian = tiff[0] == 'M' && tiff[1] == 'M';
  const bool little_endian = tiff[0] == 'I' && tiff[1] == 'I';
  if (!big_endian && !little_endian) return kUpright;
  const std::uint32_t orientation =
      find_orientation(TiffReader(tiff, big_endian)).value_or(kUpright);
  return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : kUpright;
}

ColorImage apply_orientation(ColorImage image, int orientation) {
  if (orientation == kUpright) return image;
  const bool exchange = orientation >= 5;
  const int width = image.width();
  const int height = image.height();
  ColorImage upright(exchange ? height : width, exchange ? width : height);
  for (int y = 0; y < upright.height(); ++y) {
    for (int x = 0; x < upright.width(); ++x) {
      // The stored pixel that belongs at (x, y).
      int from_x = exchange ? y : x;
      int from_y = exchange ? x : y;
      if (orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8) {
        from_x = width - 1 - from_x;
      }
      if (orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7) {
        from_y = height - 1 - from_y;
      }
      upright.at(x, y) = image.at(from_x, from_y);
    }
  }
  return upright;
}

}  // namespace roomwise::image
