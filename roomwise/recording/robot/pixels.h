#pragma once

#include "roomwise/image/image.h"
#include "roomwise/recording/messages/messages.h"

// Pictures out of messages. Each function fails where the message is of a kind that is not read, or
// has fewer bytes than its size asks for.
namespace roomwise::recording {

enum class PixelKind { kColor, kGray, kDepth, kOther };

[[nodiscard]] PixelKind pixel_kind(const ImageMessage& image);
[[nodiscard]] PixelKind pixel_kind(const CompressedImageMessage& image);

// rgb8, bgr8, rgba8, bgra8, mono8, OpenCV's names of the same (8UC1, 8UC3, 8UC4: BGR), and 4:2:2
// luma and chroma (yuv422, yuv422_yuy2).
[[nodiscard]] Expected<image::ColorImage> color_of(const ImageMessage& image);
// JPEG, PNG, WebP.
[[nodiscard]] Expected<image::ColorImage> color_of(const CompressedImageMessage& image);

// 16UC1 and mono16 as they are; 32FC1 (m) in mm, where NaN, infinities, what is not positive and
// what is beyond 65 m are 0.
[[nodiscard]] Expected<image::DepthImage> depth_of(const ImageMessage& image);
// 16-bit PNG; ROS's compressedDepth as PNG or RVL: 16UC1, or 32FC1 (to mm) as inverse depth.
[[nodiscard]] Expected<image::DepthImage> depth_of(const CompressedImageMessage& image);
// The PNG that depth_of() would decode, where it needs nothing more.
[[nodiscard]] std::span<const std::uint8_t> depth_png_of(const CompressedImageMessage& image);

}  // namespace roomwise::recording
