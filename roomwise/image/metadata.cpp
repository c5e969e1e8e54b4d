#include "roomwise/image/metadata.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "roomwise/image/codec.h"

namespace roomwise::image {
namespace {

using Span = std::span<const std::uint8_t>;

// A segment of a JPEG, a chunk of a PNG or a WebP.
struct Part {
  std::uint32_t what = 0;  // the marker, or the four letters, the first one highest
  Span whole;              // as it stands in the file; with the pixels that follow a JPEG's SOS
  Span content;
};
using Parts = std::optional<std::vector<Part>>;

constexpr std::uint32_t letters(std::string_view four) {
  std::uint32_t value = 0;
  for (const char letter : four) value = value << 8U | static_cast<std::uint8_t>(letter);
  return value;
}

std::uint32_t big_endian(Span bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8U | byte;
  return value;
}

std::string_view as_text(Span bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void append(Bytes& to, Span bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

// Markers of JPEG (ITU-T T.81, table B.1).
constexpr std::uint8_t kSoi = 0xD8, kEoi = 0xD9, kSos = 0xDA, kApp0 = 0xE0, kApp1 = 0xE1,
                       kApp14 = 0xEE, kApp15 = 0xEF, kCom = 0xFE, kTem = 0x01;
constexpr bool is_restart(std::uint8_t marker) {
  return marker >= 0xD0 && marker <= 0xD7;
}

// Where the pixels behind an SOS end: at the next marker that is none of theirs.
std::size_t end_of_pixels(Span jpeg, std::size_t at) {
  while (at < jpeg.size()) {
    if (jpeg[at] != 0xFF) {
      ++at;
      continue;
    }
    const std::size_t marker_at = at;
    while (at < jpeg.size() && jpeg[at] == 0xFF) ++at;
    if (at == jpeg.size() || (jpeg[at] != 0 && !is_restart(jpeg[at]))) return marker_at;
  }
  return at;
}

// What libjpeg passes over between segments is in none of them.
Parts jpeg_parts(Span jpeg) {
  std::vector<Part> parts;
  for (std::size_t at = 2;;) {
    while (at < jpeg.size() && jpeg[at] != 0xFF) ++at;
    while (at < jpeg.size() && jpeg[at] == 0xFF) ++at;
    if (at >= jpeg.size()) return std::nullopt;
    const std::uint8_t marker = jpeg[at++];
    if (marker == kEoi) return parts;
    if (marker == 0 || marker == kTem || is_restart(marker)) continue;
    if (marker == kSoi || jpeg.size() - at < 2) return std::nullopt;
    const std::size_t size = big_endian(jpeg.subspan(at, 2));
    if (size < 2 || size > jpeg.size() - at) return std::nullopt;
    const std::size_t end = marker == kSos ? end_of_pixels(jpeg, at + size) : at + size;
    parts.push_back({marker, jpeg.subspan(at - 2, end - at + 2), jpeg.subspan(at + 2, size - 2)});
    at = end;
  }
}

constexpr std::size_t kPngSignature = 8;

Parts png_parts(Span png) {
  constexpr std::size_t kAroundContent = 12;  // size, letters; CRC
  std::vector<Part> parts;
  for (std::size_t at = kPngSignature; png.size() - at >= kAroundContent;) {
    const std::size_t size = big_endian(png.subspan(at, 4));
    if (size > png.size() - at - kAroundContent) return std::nullopt;
    parts.push_back({big_endian(png.subspan(at + 4, 4)), png.subspan(at, size + kAroundContent),
                     png.subspan(at + 8, size)});
    if (parts.back().what == letters("IEND")) return parts;
    at += size + kAroundContent;
  }
  return std::nullopt;
}

constexpr std::size_t kRiffHead = 12;  // "RIFF", size, "WEBP"

std::size_t little_endian(Span bytes) {
  std::size_t value = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) value = value << 8U | bytes[i - 1];
  return value;
}

Parts webp_parts(Span webp) {
  constexpr std::size_t kHead = 8;
  webp = webp.first(std::min(webp.size(), kHead + little_endian(webp.subspan(4, 4))));
  std::vector<Part> parts;
  for (std::size_t at = kRiffHead; at + kHead <= webp.size();) {
    const std::size_t size = little_endian(webp.subspan(at + 4, 4));
    if (size > webp.size() - at - kHead) return std::nullopt;
    const std::size_t padded = std::min(size + size % 2, webp.size() - at - kHead);
    parts.push_back({big_endian(webp.subspan(at, 4)), webp.subspan(at, kHead + padded),
                     webp.subspan(at + kHead, size)});
    at += kHead + padded;
  }
  return parts;
}

Parts parts_of(Span picture) {
  if (is_jpeg(picture)) return jpeg_parts(picture);
  if (is_png(picture)) return png_parts(picture);
  return is_webp(picture) ? webp_parts(picture) : std::nullopt;
}

void append_segment(Bytes& jpeg, std::uint32_t marker, Span content) {
  const std::size_t size = content.size() + 2;
  append(jpeg, std::array{std::uint8_t{0xFF}, static_cast<std::uint8_t>(marker),
                          static_cast<std::uint8_t>(size >> 8U), static_cast<std::uint8_t>(size)});
  append(jpeg, content);
}

Bytes exif_of_orientation(int orientation) {
  return {
      'E', 'x', 'i', 'f',  0,    0, 'M', 'M', 0, 42, 0, 0, 0,
      8,   0,   1,   0x01, 0x12, 0, 3,   0,   0, 0,  1, 0, static_cast<std::uint8_t>(orientation),
      0,   0,   0,   0,    0,    0};
}

// Of the segments for applications libjpeg asks two how the colours are meant; their first bytes
// say it, and a thumbnail may follow.
void append_what_colors_need(Bytes& jpeg, const Part& part) {
  constexpr std::size_t kJfif = 14, kAdobe = 12;
  const std::string_view text = as_text(part.content);
  if (part.what == kApp0 && text.size() >= kJfif &&
      text.starts_with(std::string_view("JFIF\0", 5))) {
    Bytes content(part.content.begin(), part.content.begin() + kJfif);
    content[kJfif - 2] = content[kJfif - 1] = 0;  // the thumbnail's sides
    append_segment(jpeg, kApp0, content);
  }
  if (part.what == kApp14 && text.size() >= kAdobe && text.starts_with("Adobe")) {
    append_segment(jpeg, kApp14, part.content.first(kAdobe));
  }
}

Bytes bare_jpeg(const std::vector<Part>& parts) {
  Bytes bare{0xFF, kSoi};
  bool is_turned = false, is_in_head = true;
  for (const Part& part : parts) {
    is_in_head = is_in_head && part.what != kSos;
    if (part.what == kCom || (part.what >= kApp0 && part.what <= kApp15)) {
      append_what_colors_need(bare, part);
      const int orientation =
          part.what == kApp1 && is_in_head ? exif_orientation(part.content) : kUpright;
      if (orientation == kUpright || is_turned) continue;
      is_turned = true;
      append_segment(bare, kApp1, exif_of_orientation(orientation));
    } else {
      append(bare, part.whole);
    }
  }
  append(bare, std::array{std::uint8_t{0xFF}, kEoi});
  return bare;
}

// What a decoder must know (a capital letter), and what transparency and shades mean.
Bytes bare_png(Span png, const std::vector<Part>& parts) {
  constexpr std::array kKept{letters("tRNS"), letters("gAMA"), letters("cHRM"), letters("sRGB"),
                             letters("sBIT")};
  constexpr std::uint32_t kAncillary = 0x20000000;
  Bytes bare(png.begin(), png.begin() + kPngSignature);
  for (const Part& part : parts) {
    const bool is_kept =
        (part.what & kAncillary) == 0 || std::ranges::find(kKept, part.what) != kKept.end();
    if (is_kept) append(bare, part.whole);
  }
  return bare;
}

Bytes bare_webp(Span webp, const std::vector<Part>& parts) {
  constexpr std::uint8_t kSaysMore = 0x20 | 0x08 | 0x04;  // profile, Exif, XMP
  constexpr std::array kKept{letters("VP8 "), letters("VP8L"), letters("VP8X"), letters("ALPH")};
  Bytes bare(webp.begin(), webp.begin() + kRiffHead);
  for (const Part& part : parts) {
    if (std::ranges::find(kKept, part.what) == kKept.end()) continue;
    append(bare, part.whole);
    if (part.what == letters("VP8X") && !part.content.empty()) {
      bare[bare.size() - part.whole.size() + 8] &= static_cast<std::uint8_t>(~kSaysMore);
    }
  }
  const std::size_t size = bare.size() - 8;
  for (std::size_t i = 0; i < 4; ++i) bare[4 + i] = static_cast<std::uint8_t>(size >> 8 * i);
  return bare;
}

PersonalData facts_of_xmp(std::string_view xmp) {
  const auto says = [&](std::initializer_list<const char*> names) {
    return std::ranges::any_of(names, [&](const char* name) { return xmp.find(name) != xmp.npos; });
  };
  return {says({"GPSLatitude", "GPSLongitude", "photoshop:City", "Iptc4xmpCore:Location"}),
          says({"tiff:Make", "tiff:Model", "SerialNumber"}),
          says({"dc:creator", "OwnerName", "xmpRights:Owner"})};
}

PersonalData facts_of_jpeg_part(const Part& part) {
  if (part.what != kApp1) return {};
  const std::string_view text = as_text(part.content);
  return text.starts_with("http://ns.adobe.com/") ? facts_of_xmp(text)
                                                  : exif_personal_data(part.content);
}

PersonalData facts_of_exif(Span tiff) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  Bytes app1(kExif.begin(), kExif.end());
  if (as_text(tiff).starts_with(kExif)) app1.clear();  // some write it in other files, too
  append(app1, tiff);
  return exif_personal_data(app1);
}

// Of a text's keyword those that the standard of PNG has.
PersonalData facts_of_png_part(const Part& part) {
  const std::string_view text = as_text(part.content);
  if (part.what == letters("eXIf")) return facts_of_exif(part.content);
  if (part.what == letters("iTXt") && text.starts_with("XML:com.adobe.xmp")) {
    return facts_of_xmp(text);
  }
  if (part.what == letters("tEXt") || part.what == letters("zTXt") ||
      part.what == letters("iTXt")) {
    const std::string_view keyword = text.substr(0, text.find('\0'));
    return {false, keyword == "Source", keyword == "Author" || keyword == "Copyright"};
  }
  return {};
}

PersonalData facts_of_webp_part(const Part& part) {
  if (part.what == letters("EXIF")) return facts_of_exif(part.content);
  return part.what == letters("XMP ") ? facts_of_xmp(as_text(part.content)) : PersonalData();
}

}  // namespace

std::optional<Bytes> without_metadata(Span picture) {
  const Parts parts = parts_of(picture);
  if (!parts) return std::nullopt;
  if (is_jpeg(picture)) return bare_jpeg(*parts);
  return is_png(picture) ? bare_png(picture, *parts) : bare_webp(picture, *parts);
}

PersonalData personal_data_of(Span picture) {
  const auto facts_of_part = is_jpeg(picture)  ? facts_of_jpeg_part
                             : is_png(picture) ? facts_of_png_part
                                               : facts_of_webp_part;
  PersonalData facts;
  const Parts parts = parts_of(picture);
  if (!parts) return facts;
  for (const Part& part : *parts) facts |= facts_of_part(part);
  return facts;
}

}  // namespace roomwise::image
