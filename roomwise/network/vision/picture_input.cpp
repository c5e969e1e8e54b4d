#include "roomwise/network/vision/picture_input.h"

#include <algorithm>

#include "roomwise/image/resample.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

// The largest centred part of the image that has the proportions of width x height.
ColorImage center_crop(const ColorImage& image, int width, int height) {
  const auto scaled = [](int side, int numerator, int denominator) {
    return std::max(1, static_cast<int>(static_cast<std::int64_t>(side) * numerator / denominator));
  };
  const int crop_width = std::min(image.width(), scaled(image.height(), width, height));
  const int crop_height = std::min(image.height(), scaled(image.width(), height, width));
  return image::crop(image, (image.width() - crop_width) / 2, (image.height() - crop_height) / 2,
                     crop_width, crop_height);
}

// Which colour the input's first, second and third channel hold.
std::uint8_t Rgb8::*channel_of(ColorOrder order, std::size_t channel) {
  if (channel == 1) return &Rgb8::g;
  return (order == ColorOrder::kRgb) == (channel == 0) ? &Rgb8::r : &Rgb8::b;
}

}  // namespace

Tensor picture_input(const ColorImage& image, const ModelCard& card) {
  const int width = card.input_width_px;
  const int height = card.input_height_px;
  const ColorImage fitted =
      image::resize(card.fit == PictureFit::kCenterCrop ? center_crop(image, width, height) : image,
                    width, height);
  Tensor input{{1, 3, height, width}, std::vector<float>(3 * fitted.pixels().size())};
  float* value = input.values.data();
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto color = channel_of(card.color_order, channel);
    for (const Rgb8 pixel : fitted.pixels()) {
      *value++ = (static_cast<float>(pixel.*color) - card.mean[channel]) * card.scale[channel];
    }
  }
  return input;
}

}  // namespace roomwise::network
