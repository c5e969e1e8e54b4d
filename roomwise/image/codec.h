#pragma once

#include <cstdint>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/image/exif.h"
#include "roomwise/image/rgbd_frame.h"

namespace roomwise::image {

// Pictures with more pixels are refused before any memory is taken (a decompression bomb, not a
// photo).
constexpr std::int64_t kMaxPixels = 100'000'000;

// What the first bytes say a file is.
[[nodiscard]] bool is_jpeg(std::span<const std::uint8_t> bytes);
[[nodiscard]] bool is_png(std::span<const std::uint8_t> bytes);

[[nodiscard]] bool is_webp(std::span<const std::uint8_t> bytes);

// Decodes a JPEG, PNG or WebP (told apart by its first bytes) to 8-bit RGB: grey is spread, an
// alpha channel is blended over black, and the orientation that a phone writes into a JPEG's Exif
// is applied. A truncated or damaged file is an error, never a half-grey picture; so is one with
// more pixels than `max_pixels`, before any memory is taken.
[[nodiscard]] Expected<ColorImage> decode_color(std::span<const std::uint8_t> bytes,
                                                std::int64_t max_pixels = kMaxPixels);

// Decodes a 16-bit greyscale PNG. Any other picture is an error that says what was found.
[[nodiscard]] Expected<DepthImage> decode_depth(std::span<const std::uint8_t> bytes,
                                                std::int64_t max_pixels = kMaxPixels);

// The same from a file; errors name it.
[[nodiscard]] Expected<ColorImage> read_color(const std::filesystem::path& path);
[[nodiscard]] Expected<DepthImage> read_depth(const std::filesystem::path& path);

// As its sensor read it, whatever Exif says of turning it: so lies the depth image beside it.
[[nodiscard]] Expected<ColorImage> read_color_as_taken(const std::filesystem::path& path);

// A picture, and what it says itself of the lens that took it (a JPEG's Exif).
struct Photo {
  ColorImage color;
  std::optional<ExifLens> lens;
};
[[nodiscard]] Expected<Photo> decode_photo(std::span<const std::uint8_t> bytes,
                                           std::int64_t max_pixels = kMaxPixels);
[[nodiscard]] Expected<Photo> read_photo(const std::filesystem::path& path);

// quality: 1 to 100. The image must have pixels, for a JPEG at most 65,500 a side. A depth image is
// packed for speed: a live camera's frames are stored as they come.
[[nodiscard]] Bytes encode_jpeg(const ColorImage& image, int quality);
[[nodiscard]] Bytes encode_png(const ColorImage& image);
[[nodiscard]] Bytes encode_png(const DepthImage& image);
// The same of depth that was interpolated and runs on from row to row: half as large, and sooner.
[[nodiscard]] Bytes encode_smooth_png(const DepthImage& image);

// The images of a frame as files: as its source gave them, without what they say besides the
// picture (metadata.h), else encoded without loss.
[[nodiscard]] Bytes color_file(const RgbdFrame& frame);
[[nodiscard]] Bytes depth_file(const RgbdFrame& frame);

}  // namespace roomwise::image
