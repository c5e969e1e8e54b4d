#include "roomwise/features/keypoint_selection.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace roomwise::features {
namespace {

// Leaves no two different key-points equal, so that every sort gives the same order.
bool is_stronger(const Keypoint& a, const Keypoint& b) {
  if (a.response != b.response) return a.response > b.response;
  const auto key = [](const Keypoint& k) {
    return std::tuple(k.position_px.y(), k.position_px.x(), k.size_px, k.angle_rad);
  };
  return key(a) < key(b);
}

}  // namespace

void KeypointSelection::select(std::vector<Keypoint>& keypoints, std::size_t most, int width,
                               int height, int spread_cells) {
  const bool too_many = most > 0 && keypoints.size() > most;
  if (too_many && spread_cells == 0) {
    std::nth_element(keypoints.begin(), keypoints.begin() + static_cast<std::ptrdiff_t>(most),
                     keypoints.end(), is_stronger);
    keypoints.resize(most);
  }
  std::sort(keypoints.begin(), keypoints.end(), is_stronger);
  if (too_many && spread_cells > 0) {
    select_spread(keypoints, most, width, height, spread_cells);
  }
}

void KeypointSelection::select_spread(std::vector<Keypoint>& keypoints, std::size_t most, int width,
                                      int height, int spread_cells) {
  const float cell_px =
      static_cast<float>(std::max(width, height)) / static_cast<float>(spread_cells);
  const auto cell_of = [&](float position_px) {
    return static_cast<std::size_t>(
        std::clamp(static_cast<int>((position_px + 0.5F) / cell_px), 0, spread_cells - 1));
  };
  const auto across = static_cast<std::size_t>(spread_cells);
  taken_.assign(across * across, 0);
  ranks_.clear();
  for (const Keypoint& keypoint : keypoints) {
    ranks_.push_back(
        taken_[cell_of(keypoint.position_px.y()) * across + cell_of(keypoint.position_px.x())]++);
  }
  order_.resize(keypoints.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::nth_element(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(most), order_.end(),
                   [&](std::size_t a, std::size_t b) {
                     return std::tuple(ranks_[a], a) < std::tuple(ranks_[b], b);
                   });
  order_.resize(most);
  std::sort(order_.begin(), order_.end());  // strongest first again
  for (std::size_t i = 0; i < most; ++i) keypoints[i] = keypoints[order_[i]];
  keypoints.resize(most);
}

}  // namespace roomwise::features
