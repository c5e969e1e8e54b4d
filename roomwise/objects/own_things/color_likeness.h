#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"

// How alike two places of pictures are in colour alone, whatever the light's colour and strength.
namespace roomwise::objects {

// Shares of the log ratios of red to green and of blue to green, seven by seven; sums to 1, or is
// all zero where nothing was bright enough to have a colour.
constexpr int kColorBins = 7;
using ColorHistogram = std::array<float, static_cast<std::size_t>(kColorBins* kColorBins)>;

// The light of a picture as the mean of its channels tells it (the grey-world assumption).
struct PictureLight {
  Eigen::Vector3f mean = Eigen::Vector3f::Ones();
};
[[nodiscard]] PictureLight light_of(const image::ColorImage& picture);

// Of the pixels where `mask` is not 0 (of the picture's size).
[[nodiscard]] ColorHistogram color_histogram(const image::ColorImage& picture,
                                             const image::GrayImage& mask,
                                             const PictureLight& light);

// 0 to 1 (Bhattacharyya's coefficient).
[[nodiscard]] double color_likeness(const ColorHistogram& a, const ColorHistogram& b);

// The shares of any box of a picture in the time of one lookup a bin.
class IntegralColorHistogram {
 public:
  explicit IntegralColorHistogram(const image::ColorImage& picture);
  [[nodiscard]] ColorHistogram shares(const network::PixelBox& box) const;

 private:
  static constexpr int kCell_px = 4;
  int columns_, rows_;
  std::vector<ColorHistogram> sums_;  // of all cells above and to the left
};

}  // namespace roomwise::objects
