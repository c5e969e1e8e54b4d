#include "laboratory/simulation/render/light_point_index.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {
namespace {

constexpr float kPointReach = 0.078F;  // m: points further away tell nothing
constexpr float kColumn = 0.04F;       // m
constexpr float kAcross = 50;  // a step out of the plane counts as so many along it, squared
constexpr float kMinFacing = 0.5F;
constexpr int kBatch = 8;  // points weighed at a time

int column_of(float coordinate) {
  return floor_to_int(coordinate / kColumn);
}

// From where to where, relative to the place, a column can hold points that tell of it.
struct ColumnStretch {
  float low = 0, high = 0;  // along z
  [[nodiscard]] bool is_empty() const { return low > high; }
};

// x and y: where the column begins, relative to the place.
ColumnStretch stretch_of(float x, float y, const Eigen::Vector3f& normal) {
  const float off_x = std::max({0.0F, x, -x - kColumn}), off_y = std::max({0.0F, y, -y - kColumn});
  const float left = kPointReach * kPointReach - off_x * off_x - off_y * off_y;
  if (left <= 0) return {1, 0};
  ColumnStretch stretch{-std::sqrt(left), std::sqrt(left)};
  // The slab around the plane: |normal . offset| < thickness.
  static const float kThickness = kPointReach / std::sqrt(kAcross);
  const float begin = normal.x() * x + normal.y() * y;
  const float step_x = normal.x() * kColumn, step_y = normal.y() * kColumn;
  const float least = begin + std::min(0.0F, step_x) + std::min(0.0F, step_y) - kThickness;
  const float most = begin + std::max(0.0F, step_x) + std::max(0.0F, step_y) + kThickness;
  constexpr float kUpright = 1e-3F;
  if (std::abs(normal.z()) < kUpright) {
    return least > kUpright * kPointReach || most < -kUpright * kPointReach ? ColumnStretch{1, 0}
                                                                            : stretch;
  }
  const float a = -most / normal.z(), b = -least / normal.z();
  return {std::max(stretch.low, std::min(a, b)), std::min(stretch.high, std::max(a, b))};
}

}  // namespace

std::vector<std::uint32_t> LightPointIndex::order_of(std::span<const LightPoint> points,
                                                     std::span<const std::uint16_t> objects) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto place_of = [&](std::uint32_t i) {
    const Eigen::Vector3f& position = points[i].position;
    return std::tuple(objects[i], column_of(position.x()), column_of(position.y()), position.z(),
                      i);
  };
  std::ranges::sort(order, {}, place_of);
  return order;
}

LightPointIndex::LightPointIndex(std::span<const LightPoint> points,
                                 std::span<const std::uint16_t> objects) {
  for (const LightPoint& point : points) {
    for (const Eigen::Index axis : {0, 1, 2}) {
      positions_[static_cast<std::size_t>(axis)].push_back(point.position[axis]);
      normals_[static_cast<std::size_t>(axis)].push_back(point.normal[axis]);
    }
    openness_squared_.push_back(point.openness * point.openness);
  }
  const std::size_t padded = points.size() + kBatch;
  for (auto* lists : {&positions_, &normals_}) {
    for (std::vector<float>& list : *lists) list.resize(padded);
  }
  openness_squared_.resize(padded);
  std::size_t first = 0;
  while (first < points.size()) {
    const std::uint16_t object = objects[first];
    std::size_t end = first;
    Eigen::Vector2i low = Eigen::Vector2i::Constant(1 << 20), high = -low;
    for (; end < points.size() && objects[end] == object; ++end) {
      const Eigen::Vector3f& position = points[end].position;
      const Eigen::Vector2i place(column_of(position.x()), column_of(position.y()));
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    if (columns_.size() <= object) columns_.resize(object + 1U);
    Columns& columns = columns_[object];
    columns = {low.x(), low.y(), high.x() - low.x() + 1, high.y() - low.y() + 1,
               column_starts_.size()};
    std::size_t point = first;
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        column_starts_.push_back(static_cast<std::uint32_t>(point));
        const auto is_here = [&](std::size_t i) {
          return column_of(points[i].position.x()) == x && column_of(points[i].position.y()) == y;
        };
        while (point < end && is_here(point)) ++point;
      }
    }
    column_starts_.push_back(static_cast<std::uint32_t>(end));
    first = end;
  }
}

void LightPointIndex::find(std::uint16_t object, const Eigen::Vector3f& position,
                           const Eigen::Vector3f& normal, std::vector<Neighbor>& found) const {
  if (object >= columns_.size()) return;
  const Columns& columns = columns_[object];
  const int from_x = std::max(column_of(position.x() - kPointReach) - columns.first_x, 0);
  const int from_y = std::max(column_of(position.y() - kPointReach) - columns.first_y, 0);
  const int to_x =
      std::min(column_of(position.x() + kPointReach) - columns.first_x, columns.count_x - 1);
  const int to_y =
      std::min(column_of(position.y() + kPointReach) - columns.first_y, columns.count_y - 1);
  const std::vector<float>& heights = positions_[2];
  for (int x = from_x; x <= to_x; ++x) {
    const float begin_x = static_cast<float>(x + columns.first_x) * kColumn - position.x();
    for (int y = from_y; y <= to_y; ++y) {
      const auto start = column_starts_.begin() + static_cast<std::ptrdiff_t>(columns.offset) +
                         static_cast<std::ptrdiff_t>(x) * columns.count_y + y;
      if (start[0] == start[1]) continue;
      const float begin_y = static_cast<float>(y + columns.first_y) * kColumn - position.y();
      const ColumnStretch stretch = stretch_of(begin_x, begin_y, normal);
      if (stretch.is_empty()) continue;
      const auto column_end = heights.begin() + start[1];
      const auto low =
          std::lower_bound(heights.begin() + start[0], column_end, position.z() + stretch.low);
      const auto high = std::upper_bound(low, column_end, position.z() + stretch.high);
      weigh(static_cast<std::size_t>(low - heights.begin()),
            static_cast<std::size_t>(high - heights.begin()), position, normal, found);
    }
  }
}

void LightPointIndex::weigh(std::size_t first, std::size_t end, const Eigen::Vector3f& position,
                            const Eigen::Vector3f& normal, std::vector<Neighbor>& found) const {
  // The last points of the list are followed by as many zeros as a batch may reach beyond its end.
  using Batch = Eigen::Array<float, kBatch, 1>;
  for (; first < end; first += kBatch) {
    const auto batch = [first](const std::vector<float>& values) {
      return Batch(Eigen::Map<const Batch>(values.data() + first));
    };
    const Batch dx = batch(positions_[0]) - position.x(), dy = batch(positions_[1]) - position.y(),
                dz = batch(positions_[2]) - position.z();
    const Batch beside = normal.x() * dx + normal.y() * dy + normal.z() * dz;
    const Batch facing = normal.x() * batch(normals_[0]) + normal.y() * batch(normals_[1]) +
                         normal.z() * batch(normals_[2]);
    const Batch squared = (dx * dx + dy * dy + dz * dz + kAcross * beside * beside) *
                          (1 / (kPointReach * kPointReach));
    const Batch near = (1 - squared).max(0.0F);
    const Batch alike = (facing.abs() - kMinFacing).max(0.0F);
    const Batch weights = near * near * (alike * alike) * batch(openness_squared_);
    const auto count = static_cast<Eigen::Index>(std::min<std::size_t>(kBatch, end - first));
    for (Eigen::Index i = 0; i < count; ++i) {
      if (weights[i] > 0) {
        found.push_back({static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(i),
                         facing[i] > 0 ? weights[i] : -weights[i]});
      }
    }
  }
}

}  // namespace roomwise::simulation
