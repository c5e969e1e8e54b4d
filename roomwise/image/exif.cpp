#include "roomwise/image/exif.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "roomwise/image/metadata.h"

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

// The kinds of values that are read.
constexpr std::uint32_t kShort = 3, kLong = 4, kRational = 5;

// A directory of tags. Of each entry that is asked for the first value is read, where it is of a
// kind that it may have.
class ExifDirectory {
 public:
  ExifDirectory(const TiffReader& tiff, std::size_t start) : tiff_(tiff), start_(start) {}

  // A whole number (SHORT or LONG).
  [[nodiscard]] std::optional<std::uint32_t> whole(std::uint32_t tag) const {
    const auto entry = find(tag);
    if (!entry) return std::nullopt;
    const auto kind = tiff_.u16(*entry + 2);
    if (kind == kShort) return tiff_.u16(*entry + kValue);
    return kind == kLong ? tiff_.u32(*entry + kValue) : std::nullopt;
  }
  // A fraction (RATIONAL) that is positive.
  [[nodiscard]] std::optional<double> positive(std::uint32_t tag) const {
    const auto entry = find(tag);
    if (!entry || tiff_.u16(*entry + 2) != kRational) return std::nullopt;
    const auto where = tiff_.u32(*entry + kValue);
    if (!where) return std::nullopt;
    const auto over = tiff_.u32(*where), under = tiff_.u32(std::size_t{*where} + 4);
    if (!over || !under || *over == 0 || *under == 0) return std::nullopt;
    return 1.0 * *over / *under;
  }

  [[nodiscard]] bool has_any(std::initializer_list<std::uint32_t> tags) const {
    return std::ranges::any_of(tags, [&](std::uint32_t tag) { return find(tag).has_value(); });
  }
  // The directory whose address stands under `tag`.
  [[nodiscard]] std::optional<ExifDirectory> below(std::uint32_t tag) const {
    const auto start = whole(tag);
    return start ? std::optional(ExifDirectory(tiff_, *start)) : std::nullopt;
  }

 private:
  static constexpr std::size_t kEntrySize = 12, kValue = 8;

  [[nodiscard]] std::optional<std::size_t> find(std::uint32_t tag) const {
    const std::uint32_t entries = tiff_.u16(start_).value_or(0);
    for (std::uint32_t i = 0; i < entries; ++i) {
      const std::size_t entry = start_ + 2 + i * kEntrySize;
      const auto found = tiff_.u16(entry);
      if (!found) return std::nullopt;  // the directory runs past the end
      if (*found == tag) return entry;
    }
    return std::nullopt;
  }

  const TiffReader& tiff_;
  std::size_t start_;
};

// The TIFF structure of an APP1 segment; nothing where it holds none.
std::optional<TiffReader> tiff_in(std::span<const std::uint8_t> app1) {
  constexpr std::array<std::uint8_t, 6> kExif{'E', 'x', 'i', 'f', 0, 0};
  constexpr std::uint32_t kMagic = 42;
  if (app1.size() < kExif.size() + 2 || !std::ranges::equal(app1.first(kExif.size()), kExif)) {
    return std::nullopt;
  }
  const auto bytes = app1.subspan(kExif.size());
  const bool big_endian = bytes[0] == 'M' && bytes[1] == 'M';
  const bool little_endian = bytes[0] == 'I' && bytes[1] == 'I';
  if (!big_endian && !little_endian) return std::nullopt;
  const TiffReader tiff(bytes, big_endian);
  return tiff.u16(2) == kMagic ? std::optional(tiff) : std::nullopt;
}

// The directory whose address stands at `at`.
std::optional<ExifDirectory> directory_at(const TiffReader& tiff, std::size_t at) {
  const auto start = tiff.u32(at);
  return start ? std::optional(ExifDirectory(tiff, *start)) : std::nullopt;
}

// Of FocalPlaneXResolution; the unit is inches where none is named (Exif 2.3, 4.6.5).
std::optional<double> pixels_per_mm_in(const ExifDirectory& exif) {
  constexpr std::uint32_t kResolution = 0xA20E, kUnit = 0xA210;
  constexpr std::uint32_t kInch = 2, kCentimetre = 3, kMillimetre = 4, kMicrometre = 5;
  const auto resolution = exif.positive(kResolution);
  if (!resolution) return std::nullopt;
  switch (exif.whole(kUnit).value_or(kInch)) {
    case kInch:
      return *resolution / 25.4;
    case kCentimetre:
      return *resolution / 10;
    case kMillimetre:
      return *resolution;
    case kMicrometre:
      return *resolution * 1000;
    default:
      return std::nullopt;
  }
}

// A number of the kind that lenses have.
template <typename Number>
std::optional<double> within(const std::optional<Number>& number, double min, double max) {
  if (!number || !(*number >= min && *number <= max)) return std::nullopt;
  return static_cast<double>(*number);
}

constexpr std::uint32_t kExifDirectory = 0x8769;

int side_in(const ExifDirectory& exif, std::uint32_t tag) {
  constexpr std::uint32_t kMaxSide = 1'000'000;
  const std::uint32_t side = exif.whole(tag).value_or(0);
  return side <= kMaxSide ? static_cast<int>(side) : 0;
}

}  // namespace

int exif_orientation(std::span<const std::uint8_t> app1) {
  constexpr std::uint32_t kOrientation = 0x0112;
  const auto tiff = tiff_in(app1);
  const auto directory = tiff ? directory_at(*tiff, 4) : std::nullopt;
  const auto orientation = directory ? directory->whole(kOrientation) : std::nullopt;
  return static_cast<int>(within(orientation, 1, 8).value_or(kUpright));
}

std::optional<ExifLens> exif_lens(std::span<const std::uint8_t> app1) {
  constexpr std::uint32_t kFocalLength = 0x920A, kFocalLength35mm = 0xA405, kDigitalZoom = 0xA404,
                          kWidth = 0xA002, kHeight = 0xA003;
  const auto tiff = tiff_in(app1);
  const auto first = tiff ? directory_at(*tiff, 4) : std::nullopt;
  const auto exif = first ? first->below(kExifDirectory) : std::nullopt;
  if (!exif) return std::nullopt;
  ExifLens lens;
  lens.focal_length_mm = within(exif->positive(kFocalLength), 0.1, 2000);
  lens.focal_length_35mm_mm = within(exif->whole(kFocalLength35mm), 1, 2000);
  lens.pixels_per_mm = within(pixels_per_mm_in(*exif), 1, 100'000);
  lens.digital_zoom = within(exif->positive(kDigitalZoom), 1, 1000);
  lens.width = side_in(*exif, kWidth);
  lens.height = side_in(*exif, kHeight);
  return lens.tells_focal_length() ? std::optional(lens) : std::nullopt;
}

PersonalData exif_personal_data(std::span<const std::uint8_t> app1) {
  constexpr std::uint32_t kGpsDirectory = 0x8825, kLatitude = 2, kLongitude = 4;
  constexpr std::uint32_t kMake = 0x010F, kModel = 0x0110, kComputer = 0x013C, kSerial = 0xA431;
  constexpr std::uint32_t kArtist = 0x013B, kCopyright = 0x8298, kCameraOwner = 0xA430;
  PersonalData facts;
  const auto tiff = tiff_in(app1);
  const auto first = tiff ? directory_at(*tiff, 4) : std::nullopt;
  if (!first) return facts;
  const auto gps = first->below(kGpsDirectory), exif = first->below(kExifDirectory);
  facts.place = gps && gps->has_any({kLatitude, kLongitude});
  facts.device = first->has_any({kMake, kModel, kComputer}) || (exif && exif->has_any({kSerial}));
  facts.owner = first->has_any({kArtist, kCopyright}) || (exif && exif->has_any({kCameraOwner}));
  return facts;
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
