#include "roomwise/features/keypoint_selection.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace roomwise::features {
namespace {

// The place of each key-point among those of its cell, 0 for the strongest. Sorted input.
std::vector<std::size_t> ranks_in_cells(const std::vector<Keypoint>& keypoints, int width,
                                        int height, int cells) {
  const float cell_px = static_cast<float>(std::max(width, height)) / static_cast<float>(cells);
  const auto cell_of = [&](float position_px) {
    return static_cast<std::size_t>(
        std::clamp(static_cast<int>((position_px + 0.5F) / cell_px), 0, cells - 1));
  };
  const auto across = static_cast<std::size_t>(cells);
  std::vector<std::size_t> taken(across * across);
  std::vector<std::size_t> ranks;
  ranks.reserve(keypoints.size());
  for (const Keypoint& keypoint : keypoints) {
    ranks.push_back(
        taken[cell_of(keypoint.position_px.y()) * across + cell_of(keypoint.position_px.x())]++);
  }
  return ranks;
}

}  // namespace

void sort_strongest_first(std::vector<Keypoint>& keypoints) {
  const auto key = [](const Keypoint& k) {
    return std::tuple(-k.response, k.position_px.y(), k.position_px.x(), k.size_px, k.angle_rad);
  };
  std::stable_sort(keypoints.begin(), keypoints.end(),
                   [&](const Keypoint& a, const Keypoint& b) { return key(a) < key(b); });
}

std::vector<Keypoint> select_keypoints(std::vector<Keypoint> keypoints, std::size_t most, int width,
                                       int height, int spread_cells) {
  sort_strongest_first(keypoints);
  if (keypoints.size() <= most) return keypoints;
  if (spread_cells == 0) {
    keypoints.resize(most);
    return keypoints;
  }
  const std::vector<std::size_t> ranks = ranks_in_cells(keypoints, width, height, spread_cells);
  std::vector<std::size_t> order(keypoints.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return ranks[a] < ranks[b]; });
  order.resize(most);
  std::sort(order.begin(), order.end());  // strongest first again
  std::vector<Keypoint> selected;
  selected.reserve(most);
  for (const std::size_t i : order) selected.push_back(keypoints[i]);
  return selected;
}

}  // namespace roomwise::features
