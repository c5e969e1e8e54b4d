#pragma once

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

namespace roomwise::pipeline {

// A stored picture as it is given to other programs: a JPEG or a PNG without what it says besides
// the picture, which may be where a home is; one that is to be turned as a PNG that is, since
// programs differ in whether they turn it. Fails where it cannot be decoded.
[[nodiscard]] Expected<Bytes> picture_to_share(const Bytes& stored);

}  // namespace roomwise::pipeline
