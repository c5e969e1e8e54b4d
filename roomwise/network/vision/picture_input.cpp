#include "roomwise/network/vision/picture_input.h"

#include <algorithm>
#include <cmath>

#include "roomwise/image/resample.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

constexpr Rgb8 kPadding{114, 114, 114};  // what YOLOX and YOLOv5 learned with

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

ColorImage padded(const ColorImage& image, int width, int height) {
  ColorImage result(width, height, kPadding);
  for (int y = 0; y < image.height(); ++y) std::ranges::copy(image.row(y), result.row(y).begin());
  return result;
}

// The picture in the size of the network's input.
ColorImage fit(const ColorImage& image, const ModelCard& card) {
  const int width = card.input_width_px;
  const int height = card.input_height_px;
  switch (card.fit) {
    case PictureFit::kStretch:
      return image::resize(image, width, height);
    case PictureFit::kCenterCrop:
      return image::resize(center_crop(image, width, height), width, height);
    case PictureFit::kPad:
      break;
  }
  const PictureScale scale = picture_scale(image, card);
  const auto scaled = [](int side, float by) {
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(side) * by)));
  };
  return padded(
      image::resize(image, scaled(image.width(), scale.across), scaled(image.height(), scale.down)),
      width, height);
}

// Which colour the input's first, second and third channel hold.
std::uint8_t Rgb8::*channel_of(ColorOrder order, std::size_t channel) {
  if (channel == 1) return &Rgb8::g;
  return (order == ColorOrder::kRgb) == (channel == 0) ? &Rgb8::r : &Rgb8::b;
}

}  // namespace

PictureScale picture_scale(const ColorImage& image, const ModelCard& card) {
  const float across = static_cast<float>(card.input_width_px) / static_cast<float>(image.width());
  const float down = static_cast<float>(card.input_height_px) / static_cast<float>(image.height());
  if (card.fit == PictureFit::kPad) return {std::min(across, down), std::min(across, down)};
  return {across, down};
}

Tensor picture_input(const ColorImage& image, const ModelCard& card) {
  const ColorImage fitted = fit(image, card);
  Tensor input{{1, 3, fitted.height(), fitted.width()},
               std::vector<float>(3 * fitted.pixels().size())};
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
