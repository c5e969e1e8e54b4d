#include "roomwise/evaluation/cloud_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace roomwise::evaluation {
namespace {

constexpr double kWithin1cm = 0.01;
constexpr double kWithin5cm = 0.05;
constexpr double kCellSize_m = 0.05;

// Points by the cell of a grid that they lie in.
class PointGrid {
 public:
  explicit PointGrid(std::span<const Eigen::Vector3f> points) {
    for (const Eigen::Vector3f& point : points) cells_[key(cell_of(point))].push_back(point);
  }

  // The distance to the nearest point, or infinity where it is further than `most_m`: looks at
  // shells of cells further and further out.
  [[nodiscard]] double nearest_m(const Eigen::Vector3f& point, double most_m) const {
    const Eigen::Vector3i middle = cell_of(point);
    double least_m = std::numeric_limits<double>::infinity();
    const auto shells = static_cast<int>(std::ceil(most_m / kCellSize_m));
    for (int shell = 0; shell <= shells; ++shell) {
      // Whatever lies in this shell is at least (shell - 1) cells away.
      if (least_m <= (shell - 1) * kCellSize_m) break;
      visit_shell(middle, shell, [&](const Eigen::Vector3f& other) {
        least_m = std::min(least_m, static_cast<double>((other - point).norm()));
      });
    }
    return least_m <= most_m ? least_m : std::numeric_limits<double>::infinity();
  }

 private:
  static Eigen::Vector3i cell_of(const Eigen::Vector3f& point) {
    return (point.cast<double>() / kCellSize_m).array().floor().cast<int>();
  }
  static std::int64_t key(const Eigen::Vector3i& cell) {
    constexpr std::int64_t kSpan = 1 << 20;  // cells along an axis: 50 km
    return (cell.x() * kSpan + cell.y()) * kSpan + cell.z();
  }
  template <typename Visit>
  void visit_shell(const Eigen::Vector3i& middle, int shell, const Visit& visit) const {
    for (int x = -shell; x <= shell; ++x) {
      for (int y = -shell; y <= shell; ++y) {
        const bool on_side = std::max(std::abs(x), std::abs(y)) == shell;
        const int step = on_side || shell == 0 ? 1 : 2 * shell;
        for (int z = -shell; z <= shell; z += step) {
          const auto found = cells_.find(key(middle + Eigen::Vector3i(x, y, z)));
          if (found == cells_.end()) continue;
          for (const Eigen::Vector3f& point : found->second) visit(point);
        }
      }
    }
  }

  std::unordered_map<std::int64_t, std::vector<Eigen::Vector3f>> cells_;
};

}  // namespace

Expected<CloudError> cloud_error(std::span<const Eigen::Vector3f> truth,
                                 std::span<const Eigen::Vector3f> estimate,
                                 double most_distance_m) {
  if (truth.empty() || estimate.empty()) {
    return fail("there is no point {} to compare", truth.empty() ? "of the truth" : "of the map");
  }
  if (!(most_distance_m > 0)) return fail("most_distance_m = {} must be positive", most_distance_m);
  const PointGrid grid(truth);
  CloudError error;
  error.points = estimate.size();
  std::vector<double> near;
  std::size_t within_1cm = 0, within_5cm = 0;
  for (const Eigen::Vector3f& point : estimate) {
    const double distance_m = grid.nearest_m(point, most_distance_m);
    if (std::isfinite(distance_m)) near.push_back(distance_m);
    within_1cm += distance_m <= kWithin1cm ? 1 : 0;
    within_5cm += distance_m <= kWithin5cm ? 1 : 0;
  }
  const auto count = static_cast<double>(estimate.size());
  error.far_points = estimate.size() - near.size();
  error.within_1cm = static_cast<double>(within_1cm) / count;
  error.within_5cm = static_cast<double>(within_5cm) / count;
  if (!near.empty()) error.distance_m = ErrorStatistics::of(std::move(near));
  return error;
}

}  // namespace roomwise::evaluation
