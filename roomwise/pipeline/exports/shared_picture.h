#pragma once

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

namespace roomwise::pipeline {

// A stored picture as it is given to other programs: a JPEG or a PNG as it is; one with Exif as a
// PNG without, turned as it says. Programs differ in whether they turn it, and it may say where a
// home is. Fails where it cannot be decoded.
[[nodiscard]] Expected<Bytes> picture_to_share(const Bytes& stored);

}  // namespace roomwise::pipeline
