#include "roomwise/mapping/bundle/guided_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roomwise::mapping {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

std::int32_t squared_distance(const std::int8_t* a, const std::int8_t* b, Eigen::Index length) {
  std::int32_t sum = 0;
  for (Eigen::Index i = 0; i < length; ++i) {
    const std::int32_t difference = a[i] - b[i];
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

bool is_in_picture(const Eigen::Vector3d& point_camera, const PinholeCamera& camera) {
  constexpr double kNearest_m = 0.1;
  if (!(point_camera.z() > kNearest_m)) return false;
  const Eigen::Vector2d pixel = camera.project_undistorted(point_camera);
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 &&
         pixel.y() <= camera.height - 1;
}

GuidedMatcher::GuidedMatcher(std::span<const KeyframeFeatures> keyframes,
                             const GuidedMatchingOptions& options)
    : keyframes_(keyframes), options_(options) {
  for (const KeyframeFeatures& keyframe : keyframes) cells_.push_back(cells_of(keyframe));
}

int GuidedMatcher::cell_along(double pixel) const {
  return static_cast<int>(std::floor(pixel / options_.search_px));
}

GuidedMatcher::Cells GuidedMatcher::cells_of(const KeyframeFeatures& keyframe) const {
  Cells cells;
  cells.columns = static_cast<int>(keyframe.camera.width / options_.search_px) + 1;
  cells.rows = static_cast<int>(keyframe.camera.height / options_.search_px) + 1;
  // Without its lens, a picture's corners may lie a little outside: they go to the nearest cell.
  const auto cell_at = [&](const Eigen::Vector2d& pixel) {
    const int column = std::clamp(cell_along(pixel.x()), 0, cells.columns - 1);
    const int row = std::clamp(cell_along(pixel.y()), 0, cells.rows - 1);
    return static_cast<std::size_t>(row * cells.columns + column);
  };
  cells.first.assign(static_cast<std::size_t>(cells.columns * cells.rows) + 1, 0);
  for (const LandmarkView& view : keyframe.views) ++cells.first[cell_at(view.pixel) + 1];
  for (std::size_t i = 1; i < cells.first.size(); ++i) cells.first[i] += cells.first[i - 1];
  std::vector<std::uint32_t> next(cells.first);
  cells.features.resize(keyframe.size());
  for (std::uint32_t i = 0; i < keyframe.size(); ++i)
    cells.features[next[cell_at(keyframe.views[i].pixel)]++] = i;
  return cells;
}

GuidedMatcher::Nearest GuidedMatcher::nearest(const KeyframeFeatures& from, std::size_t feature,
                                              std::uint32_t to,
                                              const Eigen::Vector2d& expected) const {
  const KeyframeFeatures& other = keyframes_[to];
  const Cells& cells = cells_[to];
  const Eigen::Index length = from.descriptors.cols();
  const std::int8_t* own = from.descriptors.row(static_cast<Eigen::Index>(feature)).data();
  std::int32_t best = std::numeric_limits<std::int32_t>::max();
  std::int32_t second = best;
  Nearest nearest;
  const int column = cell_along(expected.x());
  const int row = cell_along(expected.y());
  for (int y = std::max(0, row - 1); y <= std::min(cells.rows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(cells.columns - 1, column + 1); ++x) {
      const auto cell = static_cast<std::size_t>(y * cells.columns + x);
      for (std::uint32_t i = cells.first[cell]; i < cells.first[cell + 1]; ++i) {
        const std::uint32_t candidate = cells.features[i];
        if (other.bright[candidate] != from.bright[feature]) continue;
        const double apart2 = (other.views[candidate].pixel - expected).squaredNorm();
        if (apart2 > options_.search_px * options_.search_px) continue;
        const std::int32_t distance = squared_distance(
            own, other.descriptors.row(static_cast<Eigen::Index>(candidate)).data(), length);
        if (distance < best) {
          second = best;
          best = distance;
          nearest.feature = static_cast<int>(candidate);
        } else {
          second = std::min(second, distance);
        }
      }
    }
  }
  nearest.distance = std::sqrt(static_cast<float>(best));
  if (nearest.distance > options_.max_distance ||
      nearest.distance > options_.max_distance_ratio * std::sqrt(static_cast<float>(second))) {
    nearest.feature = -1;
  }
  return nearest;
}

std::vector<GuidedMatcher::Nearest> GuidedMatcher::find(std::uint32_t from, std::uint32_t to,
                                                        const RigidTransform& to_from_from) const {
  const KeyframeFeatures& keyframe = keyframes_[from];
  const PinholeCamera& camera = keyframes_[to].camera;
  std::vector<Nearest> found(keyframe.size());
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    if (!keyframe.has_point(i)) continue;
    const Eigen::Vector3d point = to_from_from * keyframe.points[i];
    if (is_in_picture(point, camera))
      found[i] = nearest(keyframe, i, to, camera.project_undistorted(point));
  }
  return found;
}

void GuidedMatcher::match(std::uint32_t a, std::uint32_t b, const RigidTransform& b_from_a,
                          std::vector<FeatureMatch>& matches) const {
  const std::vector<Nearest> from_a = find(a, b, b_from_a);
  const std::vector<Nearest> from_b = find(b, a, b_from_a.inverse());
  const auto belongs = [](const std::vector<Nearest>& back, const KeyframeFeatures& other,
                          std::size_t feature, std::size_t nearest) {
    return back[nearest].feature == static_cast<int>(feature) || !other.has_point(nearest);
  };
  for (std::uint32_t i = 0; i < from_a.size(); ++i) {
    if (from_a[i].feature < 0) continue;
    const auto j = static_cast<std::uint32_t>(from_a[i].feature);
    if (belongs(from_b, keyframes_[b], i, j))
      matches.push_back({{a, i}, {b, j}, from_a[i].distance});
  }
  // What both looked for is in already.
  for (std::uint32_t j = 0; j < from_b.size(); ++j) {
    if (from_b[j].feature < 0) continue;
    const auto i = static_cast<std::uint32_t>(from_b[j].feature);
    if (!keyframes_[a].has_point(i)) matches.push_back({{a, i}, {b, j}, from_b[j].distance});
  }
}

}  // namespace roomwise::mapping
