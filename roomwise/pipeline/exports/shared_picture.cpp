#include "roomwise/pipeline/exports/shared_picture.h"

#include <string_view>

#include "roomwise/image/codec.h"

namespace roomwise::pipeline {
namespace {

bool has_exif(const Bytes& picture) {
  constexpr std::string_view kJpegExif("Exif\0", 5), kPngExif("eXIf", 4);
  const std::string_view bytes(reinterpret_cast<const char*>(picture.data()), picture.size());
  return bytes.find(kJpegExif) != bytes.npos || bytes.find(kPngExif) != bytes.npos;
}

}  // namespace

Expected<Bytes> picture_to_share(const Bytes& stored) {
  if ((image::is_jpeg(stored) || image::is_png(stored)) && !has_exif(stored)) return stored;
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(stored));
  return image::encode_png(color);
}

}  // namespace roomwise::pipeline
