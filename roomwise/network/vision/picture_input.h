#pragma once

#include "roomwise/image/image.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/model_card.h"

namespace roomwise::network {

// How many pixels of a network's input one of the picture takes, by its card.
struct PictureScale {
  float across = 1, down = 1;
};
[[nodiscard]] PictureScale picture_scale(const image::ColorImage& image, const ModelCard& card);

// A picture (of at least one pixel) as a network takes it by its card: 1 x 3 x height x width.
[[nodiscard]] Tensor picture_input(const image::ColorImage& image, const ModelCard& card);

}  // namespace roomwise::network
