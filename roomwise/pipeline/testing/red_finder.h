#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "roomwise/pipeline/testing/fake_finder.h"

namespace roomwise::pipeline::testing {

// Finds what is red, and calls it a couch.
class RedFinder final : public FakeFinder {
 public:
  RedFinder() : FakeFinder("red", {"couch"}) {}

  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    Eigen::AlignedBox2f extent;
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = 0; x < picture.width(); ++x) {
        const Rgb8 color = picture.at(x, y);
        if (color.r < 240 || color.g > 10 || color.b > 10) continue;
        extent.extend(Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)));
      }
    }
    if (extent.isEmpty()) return std::vector<network::Detection>{};
    return std::vector<network::Detection>{
        {0, 0.8F, {extent.min().x(), extent.min().y(), extent.max().x(), extent.max().y()}}};
  }
};

}  // namespace roomwise::pipeline::testing
