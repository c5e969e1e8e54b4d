#include "roomwise/pipeline/exports/shared_picture.h"

#include <string_view>

#include "roomwise/image/codec.h"
#include "roomwise/image/metadata.h"

namespace roomwise::pipeline {
namespace {

// Of what metadata may say that alone is left.
bool is_turned(const Bytes& bare) {
  constexpr std::string_view kExif("Exif\0", 5);
  const std::string_view bytes(reinterpret_cast<const char*>(bare.data()), bare.size());
  return bytes.find(kExif) != bytes.npos;
}

}  // namespace

Expected<Bytes> picture_to_share(const Bytes& stored) {
  auto bare = image::without_metadata(stored);
  if (bare && !image::is_webp(stored) && !is_turned(*bare)) return *std::move(bare);
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(stored));
  return image::encode_png(color);
}

}  // namespace roomwise::pipeline
