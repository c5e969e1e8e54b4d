#include "roomwise/recording/bytes/exr.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/byte_reader.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/bytes/unpack.h"

namespace roomwise::recording {
namespace {

using ExrBytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kExrMagic = 20'000'630;
constexpr std::uint32_t kExrVersion = 2;
constexpr std::uint32_t kLongNames = 0x400;  // the one of a file's flags that changes nothing here

enum class ExrNumbers : std::uint32_t { kUint = 0, kHalf = 1, kFloat = 2 };

std::size_t size_of(ExrNumbers numbers) {
  return numbers == ExrNumbers::kHalf ? 2 : 4;
}

struct ExrChannel {
  std::string name;
  ExrNumbers numbers = ExrNumbers::kHalf;
};

// How lines are packed: none, each for itself, or sixteen together.
enum class ExrPacking : std::uint8_t { kNone = 0, kZips = 2, kZip = 3 };

struct ExrHeader {
  std::vector<ExrChannel> channels;  // as they lie in a line, by their names
  std::optional<ExrPacking> packing;
  int width = 0, height = 0;
  std::int32_t first_line = 0;

  [[nodiscard]] std::size_t line_bytes() const {
    std::size_t bytes = 0;
    for (const ExrChannel& channel : channels) bytes += size_of(channel.numbers);
    return bytes * static_cast<std::size_t>(width);
  }
  [[nodiscard]] int block_lines() const { return packing == ExrPacking::kZip ? 16 : 1; }
  [[nodiscard]] std::size_t blocks() const {
    return static_cast<std::size_t>((height + block_lines() - 1) / block_lines());
  }
};

// A text that a zero ends.
std::string text_before_zero(ByteReader& reader) {
  constexpr std::size_t kMaxName = 255;
  std::string text;
  while (reader.ok() && text.size() <= kMaxName) {
    const auto letter = reader.number<char>();
    if (letter == '\0') return text;
    text += letter;
  }
  static_cast<void>(reader.bytes(std::numeric_limits<std::uint64_t>::max()));  // it is no name
  return {};
}

Expected<std::vector<ExrChannel>> channels_in(ExrBytes value) {
  constexpr std::size_t kMaxChannels = 64;
  std::vector<ExrChannel> channels;
  ByteReader reader(value);
  while (reader.ok() && channels.size() < kMaxChannels) {
    const std::string name = text_before_zero(reader);
    if (name.empty()) break;
    const auto numbers = reader.number<std::uint32_t>();
    static_cast<void>(reader.bytes(4));  // how it is to be seen
    const auto every_x = reader.number<std::int32_t>(), every_y = reader.number<std::int32_t>();
    if (numbers > 2 || every_x != 1 || every_y != 1) {
      return fail("its channel '{}' is of a kind that is not read", name);
    }
    channels.push_back({name, static_cast<ExrNumbers>(numbers)});
  }
  if (!reader.ok() || channels.empty()) return fail("its list of channels is damaged");
  return channels;
}

Expected<ExrPacking> packing_in(ExrBytes value) {
  const std::uint8_t number = value.empty() ? std::uint8_t{255} : value[0];
  for (const auto known : {ExrPacking::kNone, ExrPacking::kZips, ExrPacking::kZip}) {
    if (number == static_cast<std::uint8_t>(known)) return known;
  }
  return fail("it is packed in a way ({}) that is not read; export it with ZIP", number);
}

Expected<void> read_data_window(ExrBytes value, std::int64_t max_pixels, ExrHeader& header) {
  ByteReader reader(value);
  const std::int64_t left = reader.number<std::int32_t>(), top = reader.number<std::int32_t>();
  const std::int64_t right = reader.number<std::int32_t>(), bottom = reader.number<std::int32_t>();
  const std::int64_t width = right - left + 1, height = bottom - top + 1;
  if (!reader.ok() || width < 1 || height < 1 || width > max_pixels ||
      height > max_pixels / width) {
    return fail("it claims {}x{} pixels, at most {} are read", width, height, max_pixels);
  }
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  header.first_line = static_cast<std::int32_t>(top);
  return {};
}

Expected<ExrHeader> read_exr_header(ByteReader& reader, std::int64_t max_pixels) {
  const auto magic = reader.number<std::uint32_t>(), version = reader.number<std::uint32_t>();
  if (!reader.ok() || magic != kExrMagic) return fail("it is no OpenEXR file");
  if ((version & ~kLongNames) != kExrVersion) {
    return fail("it has tiles, several parts or deep pixels, which are not read");
  }
  ExrHeader header;
  for (;;) {
    const std::string name = text_before_zero(reader);
    if (!reader.ok()) return fail("its head is cut off");
    if (name.empty()) break;
    const std::string type = text_before_zero(reader);
    const auto value = reader.counted_bytes<std::uint32_t>();
    if (!reader.ok()) return fail("its head is cut off");
    if (name == "channels" && type == "chlist") {
      ROOMWISE_TRY(header.channels, channels_in(value));
    } else if (name == "compression" && type == "compression") {
      ROOMWISE_TRY(header.packing, packing_in(value));
    } else if (name == "dataWindow" && type == "box2i") {
      ROOMWISE_RETURN_IF_ERROR(read_data_window(value, max_pixels, header));
    }
  }
  if (header.channels.empty() || !header.packing || header.width == 0) {
    return fail("its head does not say its channels, its packing and its size");
  }
  return header;
}

// Where in a line the numbers of the channel begin.
struct ExrPlace {
  std::size_t offset = 0;
  ExrNumbers numbers = ExrNumbers::kHalf;
};

Expected<ExrPlace> place_of_channel(const ExrHeader& header) {
  const auto place_of = [&](std::size_t wanted) {
    ExrPlace place{0, header.channels[wanted].numbers};
    for (std::size_t i = 0; i < wanted; ++i) {
      place.offset += size_of(header.channels[i].numbers) * static_cast<std::size_t>(header.width);
    }
    return place;
  };
  std::optional<ExrPlace> place;
  if (header.channels.size() == 1) place = place_of(0);
  for (const std::string_view name : {"R", "Z"}) {
    const auto found = std::ranges::find(header.channels, name, &ExrChannel::name);
    if (place || found == header.channels.end()) continue;
    place = place_of(static_cast<std::size_t>(found - header.channels.begin()));
  }
  if (!place) return fail("it has several channels, and none is R or Z");
  if (place->numbers == ExrNumbers::kUint) return fail("its numbers are no floats");
  return *place;
}

// What ZIP packs: differences between bytes, of which the even ones stand in front of the odd ones.
Bytes lines_of(const Bytes& unpacked) {
  Bytes bytes = unpacked;
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(bytes[i - 1] + bytes[i] - 128);
  }
  Bytes lines(bytes.size());
  const std::size_t half = (bytes.size() + 1) / 2;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    lines[i] = bytes[i % 2 == 0 ? i / 2 : half + i / 2];
  }
  return lines;
}

float from_half(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16U;
  const std::uint32_t exponent = half >> 10U & 0x1FU, mantissa = half & 0x3FFU;
  constexpr float kSmallest = 1.0F / (1 << 24);  // of those below the normal ones
  if (exponent == 0) {
    const float value = static_cast<float>(mantissa) * kSmallest;
    return sign == 0 ? value : -value;
  }
  constexpr std::uint32_t kRebias = 127 - 15, kAllOnes = 0xFFU;
  const std::uint32_t wide = exponent == 0x1FU ? kAllOnes : exponent + kRebias;
  return std::bit_cast<float>(sign | wide << 23U | mantissa << 13U);
}

void read_line(const std::uint8_t* numbers, ExrNumbers kind, std::span<float> pixels) {
  for (std::size_t x = 0; x < pixels.size(); ++x) {
    pixels[x] = kind == ExrNumbers::kHalf ? from_half(load<std::uint16_t>(numbers + 2 * x))
                                          : load<float>(numbers + 4 * x);
  }
}

// The lines of a block, which begins at `offset`.
Expected<Bytes> read_block(ExrBytes file, std::uint64_t offset, const ExrHeader& header,
                           std::size_t block) {
  if (offset > file.size()) return fail("its block {} lies beyond its end", block);
  ByteReader reader(file.subspan(static_cast<std::size_t>(offset)));
  const std::int64_t line = reader.number<std::int32_t>();
  const ExrBytes packed = reader.counted_bytes<std::uint32_t>();
  const std::int64_t first = static_cast<std::int64_t>(block) * header.block_lines();
  if (!reader.ok() || line != header.first_line + first) {
    return fail("its block {} is damaged or cut off", block);
  }
  const std::int64_t lines = std::min<std::int64_t>(header.block_lines(), header.height - first);
  const std::size_t size = header.line_bytes() * static_cast<std::size_t>(lines);
  // What packing would make no smaller is left as it is.
  if (header.packing == ExrPacking::kNone || packed.size() >= size) {
    if (packed.size() != size) return fail("its block {} has not its size", block);
    return Bytes(packed.begin(), packed.end());
  }
  ROOMWISE_TRY(const auto unpacked, in_context(fmt::format("its block {}", block),
                                               unpack(Packing::kZlib, packed, size)));
  return lines_of(unpacked);
}

}  // namespace

bool is_exr(ExrBytes bytes) {
  return bytes.size() >= 4 && load<std::uint32_t>(bytes.data()) == kExrMagic;
}

Expected<image::Image<float>> decode_exr(ExrBytes bytes, std::int64_t max_pixels) {
  ByteReader reader(bytes);
  ROOMWISE_TRY(const ExrHeader header, read_exr_header(reader, max_pixels));
  ROOMWISE_TRY(const ExrPlace place, place_of_channel(header));
  const ExrBytes table = reader.bytes(8 * header.blocks());
  if (!reader.ok()) return fail("its table of blocks is cut off");
  image::Image<float> pixels(header.width, header.height);
  for (std::size_t block = 0; block < header.blocks(); ++block) {
    const auto offset = load<std::uint64_t>(table.data() + 8 * block);
    ROOMWISE_TRY(const Bytes lines, read_block(bytes, offset, header, block));
    const int first = static_cast<int>(block) * header.block_lines();
    const int end = std::min(first + header.block_lines(), header.height);
    for (int y = first; y < end; ++y) {
      const std::size_t line = header.line_bytes() * static_cast<std::size_t>(y - first);
      read_line(lines.data() + line + place.offset, place.numbers, pixels.row(y));
    }
  }
  return pixels;
}

}  // namespace roomwise::recording
