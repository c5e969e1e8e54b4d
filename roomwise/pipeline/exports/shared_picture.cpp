#include "roomwise/pipeline/exports/shared_picture.h"

#include <algorithm>
#include <string_view>

#include "roomwise/image/codec.h"

namespace roomwise::pipeline {
namespace {

bool has_exif(const Bytes& picture) {
  constexpr std::string_view kJpegExif("Exif\0", 5), kPngExif("eXIf", 4);
  const auto holds = [&](std::string_view mark) {
    return !std::ranges::search(picture, mark, {}, {}, [](char c) {
              return static_cast<std::uint8_t>(c);
            }).empty();
  };
  return holds(kJpegExif) || holds(kPngExif);
}

}  // namespace

Expected<Bytes> picture_to_share(const Bytes& stored) {
  if ((image::is_jpeg(stored) || image::is_png(stored)) && !has_exif(stored)) return stored;
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(stored));
  return image::encode_png(color);
}

}  // namespace roomwise::pipeline
