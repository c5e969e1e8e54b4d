#pragma once

#include <filesystem>
#include <functional>

#include "roomwise/image/image.h"
#include "roomwise/network/checked_quantization.h"
#include "roomwise/network/eight_bit_file.h"

namespace roomwise::network {

struct QuantizedClassifier {
  EightBitFile file = {};  // `network` as it was given; of use only where report.is_used
  QuantizationReport report;
  std::size_t measured_on = 0, checked_on = 0;  // pictures
};

using PictureAt = std::function<Expected<image::ColorImage>(std::size_t)>;

// How a network that looks at whole pictures can be worked out in 8 bits: measured on every fourth
// of these pictures and checked on the others (checked_quantization). Of many pictures some three
// hundred, evenly spread, are taken. Fails where there are fewer than eight, one cannot be read, or
// it is no such network.
[[nodiscard]] Expected<QuantizedClassifier> quantize_classifier(
    const std::filesystem::path& weights, std::size_t pictures, const PictureAt& picture);

}  // namespace roomwise::network
