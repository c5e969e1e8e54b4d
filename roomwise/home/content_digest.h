#pragma once

#include <functional>
#include <string>

#include "roomwise/home/database.h"
#include "roomwise/home/picture_cipher.h"

namespace roomwise::home {

// The picture of a key-frame from what stands in the file.
using PlainPicture =
    std::function<Expected<Bytes>(std::uint64_t keyframe, PictureKind kind, Bytes stored)>;

// SHA-256 (lower-case hexadecimal) over every row of every table, but for times, the folders that
// recordings were read from and what follows from the rest (picture_features, derived_data). It
// depends on the values alone: not on the order in which rows were written, on transactions, on the
// layout of the file, on the order of columns, on whether the pictures are sealed.
[[nodiscard]] Expected<std::string> content_digest(const Database& database,
                                                   const PlainPicture& plain_picture);

}  // namespace roomwise::home
