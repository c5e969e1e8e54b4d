#include "roomwise/objects/detection/region_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "roomwise/base/median.h"

namespace roomwise::objects {
namespace {

constexpr int kPlacesAlong = 48;  // across the region's longer side
constexpr std::size_t kMaxPoints = 240;
constexpr std::size_t kFewestMeasured = 24;  // places
constexpr double kNearest_m = 0.3;           // depth bins begin here
constexpr double kBinRatio = 1.05;           // each bin is farther by this
constexpr std::size_t kBins = 64;            // to 6.8 m

// Depths at places of a region, row by row, in metres; 0 where nothing was measured.
struct RegionGrid {
  int columns = 0, rows = 0;
  double step_px = 1;
  double left_px = 0, top_px = 0;
  std::vector<double> depth_m;

  [[nodiscard]] Eigen::Vector2d pixel(int column, int row) const {
    return {std::round(left_px + (column + 0.5) * step_px - 0.5),
            std::round(top_px + (row + 0.5) * step_px - 0.5)};
  }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  // Of each place: its column, row and index.
  template <typename Do>
  void for_each(const Do& act) const {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) act(column, row, index(column, row));
    }
  }
  // 1 in the middle, 0 at the rim.
  [[nodiscard]] double centrality(int column, int row) const {
    const double across = 1 - std::abs(2 * (column + 0.5) / columns - 1);
    const double down = 1 - std::abs(2 * (row + 0.5) / rows - 1);
    return across * down;
  }
};

RegionGrid sample_region(const image::DepthImage& depth, const geometry::PinholeCamera& camera,
                         const network::PixelBox& box) {
  RegionGrid grid;
  grid.left_px = std::clamp<double>(box.left, 0, depth.width());
  grid.top_px = std::clamp<double>(box.top, 0, depth.height());
  const double width = std::clamp<double>(box.right, 0, depth.width()) - grid.left_px;
  const double height = std::clamp<double>(box.bottom, 0, depth.height()) - grid.top_px;
  grid.step_px = std::max(1.0, std::max(width, height) / kPlacesAlong);
  grid.columns = static_cast<int>(width / grid.step_px);
  grid.rows = static_cast<int>(height / grid.step_px);
  grid.for_each([&](int column, int row, std::size_t) {
    const Eigen::Vector2d at = grid.pixel(column, row);
    const int x = std::clamp(static_cast<int>(at.x()), 0, depth.width() - 1);
    const int y = std::clamp(static_cast<int>(at.y()), 0, depth.height() - 1);
    grid.depth_m.push_back(depth.at(x, y) / camera.depth_units_per_metre);
  });
  return grid;
}

std::optional<std::size_t> bin_of(double depth_m) {
  if (depth_m <= kNearest_m) return std::nullopt;
  const auto bin = static_cast<std::size_t>(std::log(depth_m / kNearest_m) / std::log(kBinRatio));
  return bin < kBins ? std::optional(bin) : std::nullopt;
}

// The middle of the three neighbouring bins that hold the most weight.
std::optional<std::size_t> fullest_bin(const RegionGrid& grid) {
  std::array<double, kBins> weight{};
  grid.for_each([&](int column, int row, std::size_t place) {
    if (const auto bin = bin_of(grid.depth_m[place])) weight[*bin] += grid.centrality(column, row);
  });
  std::size_t best = 1;
  double most = 0;
  for (std::size_t bin = 1; bin + 1 < kBins; ++bin) {
    const double here = weight[bin - 1] + weight[bin] + weight[bin + 1];
    if (here > most) {
      most = here;
      best = bin;
    }
  }
  return most > 0 ? std::optional(best) : std::nullopt;
}

// Neighbouring places on one surface, be it as slanted as a floor far ahead.
bool is_continuous(double a_m, double b_m, double step_px, double focal_px) {
  constexpr double kSteepest = 3;  // depth over width
  const double nearer_m = std::min(a_m, b_m);
  const double noise_m = 0.01 + 0.006 * nearer_m * nearer_m;
  return std::abs(a_m - b_m) < noise_m + kSteepest * nearer_m * step_px / focal_px;
}

// Follows the surface from the places in the fullest range of depth.
std::vector<bool> follow_surface(const RegionGrid& grid, std::size_t bin, double focal_px) {
  std::vector<bool> on_surface(grid.depth_m.size(), false);
  std::vector<std::pair<int, int>> open;
  grid.for_each([&](int column, int row, std::size_t place) {
    const auto own = bin_of(grid.depth_m[place]);
    if (!own || *own + 1 < bin || *own > bin + 1 || grid.centrality(column, row) < 0.05) return;
    on_surface[place] = true;
    open.emplace_back(column, row);
  });
  while (!open.empty()) {
    const auto [column, row] = open.back();
    open.pop_back();
    const double here_m = grid.depth_m[grid.index(column, row)];
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int x = column + dx, y = row + dy;
      if (x < 0 || y < 0 || x >= grid.columns || y >= grid.rows) continue;
      const std::size_t there = grid.index(x, y);
      if (on_surface[there] || grid.depth_m[there] <= 0) continue;
      if (!is_continuous(here_m, grid.depth_m[there], grid.step_px, focal_px)) continue;
      on_surface[there] = true;
      open.emplace_back(x, y);
    }
  }
  return on_surface;
}

std::size_t places_measured(const RegionGrid& grid) {
  return static_cast<std::size_t>(
      std::ranges::count_if(grid.depth_m, [](double depth_m) { return depth_m > 0; }));
}

// A sample of the places that are on it.
DetectionSurface surface_of(const RegionGrid& grid, const std::vector<bool>& on_surface,
                            const geometry::PinholeCamera& camera) {
  DetectionSurface surface;
  const auto measured = static_cast<float>(places_measured(grid));
  const auto places = static_cast<std::size_t>(std::ranges::count(on_surface, true));
  surface.measured = measured / static_cast<float>(grid.depth_m.size());
  surface.share = static_cast<float>(places) / measured;
  const std::size_t every = (places + kMaxPoints - 1) / kMaxPoints;
  std::size_t next = 0;
  grid.for_each([&](int column, int row, std::size_t place) {
    if (!on_surface[place] || next++ % every != 0) return;
    surface.points.push_back(
        camera.unproject(grid.pixel(column, row), grid.depth_m[place]).cast<float>());
  });
  return surface;
}

}  // namespace

DetectionSurface region_surface(const image::DepthImage& depth,
                                const geometry::PinholeCamera& camera,
                                const network::PixelBox& box) {
  const RegionGrid grid = sample_region(depth, camera, box);
  if (places_measured(grid) < kFewestMeasured) return {};
  const auto bin = fullest_bin(grid);
  if (!bin) return surface_of(grid, std::vector<bool>(grid.depth_m.size(), false), camera);
  return surface_of(grid, follow_surface(grid, *bin, camera.fx), camera);
}

DetectionSurface surface_within(const image::DepthImage& depth,
                                const geometry::PinholeCamera& camera, const network::PixelBox& box,
                                const geometry::OrientedBox& box_camera) {
  constexpr double kRim_m = 0.04;
  const RegionGrid grid = sample_region(depth, camera, box);
  if (places_measured(grid) < kFewestMeasured) return {};
  std::vector<bool> on_surface(grid.depth_m.size(), false);
  grid.for_each([&](int column, int row, std::size_t place) {
    if (grid.depth_m[place] <= 0) return;
    const Eigen::Vector3d point = camera.unproject(grid.pixel(column, row), grid.depth_m[place]);
    on_surface[place] = box_camera.distance_m(point) <= kRim_m;
  });
  return surface_of(grid, on_surface, camera);
}

image::DepthImage coarse_depth(const image::DepthImage& depth) {
  constexpr int kStep = kCoarseDepthStep_px;
  image::DepthImage coarse(depth.width() / kStep, depth.height() / kStep);
  std::vector<std::uint16_t> measured;
  for (int row = 0; row < coarse.height(); ++row) {
    for (int column = 0; column < coarse.width(); ++column) {
      measured.clear();
      for (int y = row * kStep; y < (row + 1) * kStep; y += 2) {
        for (int x = column * kStep; x < (column + 1) * kStep; x += 2) {
          if (depth.at(x, y) != 0) measured.push_back(depth.at(x, y));
        }
      }
      if (measured.size() < 4) continue;
      coarse.at(column, row) = median_of(measured);
    }
  }
  return coarse;
}

}  // namespace roomwise::objects
