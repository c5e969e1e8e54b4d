#include "roomwise/mapping/backend/refinement_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <set>

#include "roomwise/mapping/bundle/landmarks.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// Key-frames by where they are.
class KeyframesInSpace {
 public:
  KeyframesInSpace(std::span<const RigidTransform> poses, std::span<const std::size_t> groups)
      : poses_(poses), groups_(groups) {
    for (KeyframeId id = 0; id < poses.size(); ++id) cells_[cell_of(id)].push_back(id);
  }

  // Calls take(id) for the others that may show the same, always in the same order.
  template <typename Take>
  void for_each_around(KeyframeId id, const Take& take) const {
    const Cell middle = cell_of(id);
    for (int i = 0; i < 27; ++i) {
      const auto cell = cells_.find(
          {middle[0], middle[1] + i / 9 - 1, middle[2] + i / 3 % 3 - 1, middle[3] + i % 3 - 1});
      if (cell == cells_.end()) continue;
      for (const KeyframeId other : cell->second) {
        if (other != id && may_be_covisible(poses_[id].inverse() * poses_[other])) take(other);
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 4>;  // group and place
  [[nodiscard]] Cell cell_of(KeyframeId id) const {
    const Eigen::Array3d place = (poses_[id].translation.array() / kMaxCovisible_m).floor();
    return {static_cast<std::int64_t>(groups_[id]), static_cast<std::int64_t>(place.x()),
            static_cast<std::int64_t>(place.y()), static_cast<std::int64_t>(place.z())};
  }

  std::span<const RigidTransform> poses_;
  std::span<const std::size_t> groups_;
  std::map<Cell, std::vector<KeyframeId>> cells_;
};

// Cuts the map window by window.
class Divider {
 public:
  Divider(std::size_t keyframes, const KeyframesInSpace& space)
      : space_(space), is_taken_(keyframes, false) {}

  // The next window's key-frames; none are left where it is empty. The nearest to where it begins
  // come first, so both times that a walk was there.
  [[nodiscard]] std::vector<KeyframeId> next(std::size_t most) {
    std::vector<KeyframeId> own;
    std::set<KeyframeId> reached;  // by this window
    std::deque<KeyframeId> open;   // of these, not taken yet
    while (own.size() < most) {
      if (open.empty()) {
        const KeyframeId start = next_start();
        if (start == is_taken_.size()) break;
        reached.insert(start);
        open.push_back(start);
      }
      const KeyframeId id = open.front();
      open.pop_front();
      is_taken_[id] = true;
      border_.erase(id);
      own.push_back(id);
      space_.for_each_around(id, [&](KeyframeId other) {
        if (!is_taken_[other] && reached.insert(other).second) open.push_back(other);
      });
    }
    // What it left lies beside it: the next goes on from there.
    border_.insert(open.begin(), open.end());
    std::ranges::sort(own);
    return own;
  }

 private:
  [[nodiscard]] KeyframeId next_start() {
    if (!border_.empty()) return *border_.begin();
    while (next_free_ < is_taken_.size() && is_taken_[next_free_]) ++next_free_;
    return next_free_;
  }

  const KeyframesInSpace& space_;
  std::vector<bool> is_taken_;
  std::set<KeyframeId> border_;  // of all windows so far, not taken yet
  KeyframeId next_free_ = 0;
};

std::vector<KeyframeId> keyframes_around(std::span<const KeyframeId> own,
                                         const KeyframesInSpace& space, std::size_t most) {
  std::map<KeyframeId, std::size_t> shared;  // with how many of the window's own
  for (const KeyframeId id : own) {
    space.for_each_around(id, [&](KeyframeId other) {
      if (!std::ranges::binary_search(own, other)) ++shared[other];
    });
  }
  std::vector<std::pair<KeyframeId, std::size_t>> around(shared.begin(), shared.end());
  std::ranges::stable_sort(around, std::ranges::greater(),
                           [](const auto& one) { return one.second; });
  around.resize(std::min(around.size(), most));
  std::vector<KeyframeId> ids;
  for (const auto& [id, count] : around) ids.push_back(id);
  std::ranges::sort(ids);
  return ids;
}

}  // namespace

std::vector<RefinementWindow> refinement_windows(
    std::span<const RigidTransform> world_from_keyframe, std::span<const std::size_t> groups,
    std::size_t max_own, std::size_t max_around) {
  const KeyframesInSpace space(world_from_keyframe, groups);
  Divider divider(world_from_keyframe.size(), space);
  std::vector<RefinementWindow> windows;
  for (auto own = divider.next(max_own); !own.empty(); own = divider.next(max_own)) {
    std::vector<KeyframeId> around = keyframes_around(own, space, max_around);
    windows.push_back({std::move(own), std::move(around)});
  }
  return windows;
}

}  // namespace roomwise::mapping
