#pragma once

#include <filesystem>
#include <functional>

#include "roomwise/image/image.h"
#include "roomwise/network/executor/checked_quantization.h"
#include "roomwise/network/formats/eight_bit_file.h"

namespace roomwise::network {

// Of fewer pictures, 98 % mean little.
constexpr std::size_t kMinQuantizationPictures = 80;

struct QuantizedClassifier {
  EightBitFile file = {};  // `network` as it was given; of use only where report.is_used
  QuantizationReport report;
  std::size_t measured_on = 0, checked_on = 0;  // pictures
};

using PictureAt = std::function<Expected<image::ColorImage>(std::size_t)>;

// How a network that looks at whole pictures can be worked out in 8 bits: measured on a quarter of
// these pictures, four neighbours each, and checked on the others (checked_quantization). Of many
// pictures 320, evenly spread, are taken. Fails where there are fewer than
// kMinQuantizationPictures, where one cannot be read, or it is no such network. `runs_done`: see
// checked_quantization().
[[nodiscard]] Expected<QuantizedClassifier> quantize_classifier(
    const std::filesystem::path& weights, std::size_t pictures, const PictureAt& picture,
    std::size_t threads = 1, const RunsDone& runs_done = {});

}  // namespace roomwise::network
