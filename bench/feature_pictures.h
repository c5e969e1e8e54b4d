#pragma once

#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::bench {

// The grey pictures on which features are measured: of fr1/rpy and of office_walk in ROOMWISE_DATA
// `a_recording` each, evenly over the recording.
[[nodiscard]] Expected<std::vector<image::GrayImage>> load_feature_pictures(int a_recording);

}  // namespace roomwise::bench
