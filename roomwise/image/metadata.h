#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/image/personal_data.h"

namespace roomwise::image {

// The file of a JPEG, PNG or WebP picture with what its pixels need, and nothing else: no Exif,
// XMP, IPTC, comment, thumbnail, profile, maker's note, nor what stands behind its end. It decodes
// to the same picture: of Exif that turns a JPEG the orientation stays. Nothing where the file is
// of another kind or its parts cannot be told apart.
[[nodiscard]] std::optional<Bytes> without_metadata(std::span<const std::uint8_t> picture);

// Whether the payload of a JPEG's APP1 segment says where the picture was taken, with what and by
// whom; that is not read.
[[nodiscard]] PersonalData exif_personal_data(std::span<const std::uint8_t> app1);

// What the file says of people and places besides the picture, as far as it is written in the ways
// that cameras and phones use.
[[nodiscard]] PersonalData personal_data_of(std::span<const std::uint8_t> picture);

}  // namespace roomwise::image
