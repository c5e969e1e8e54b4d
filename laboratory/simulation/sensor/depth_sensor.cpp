#include "laboratory/simulation/sensor/depth_sensor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "laboratory/simulation/scene/noise.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr std::uint64_t kPixelStream = 0xDE97u, kCellStream = 0xCE11u;

// A first Kinect: the projector stands 75 mm to the right of the camera, the focal length is 580 px
// at 640 px of width, and disparity is found to 1/8 px.
constexpr double kBaseline_m = 0.075;
constexpr double kDisparity_px_m = kBaseline_m * 580;
constexpr double kDisparityStep_px = 0.125;

// A jump of depth by more than this share is an edge between things.
constexpr float kEdgeShare = 0.03F;
// Standard deviation of the sideways error at edges (Nguyen, Izadi and Lovell 2012: 0.8 px).
constexpr double kEdgeJitter_px = 0.8;

// Mirrors send the pattern elsewhere: from the first share of mirrored light on some of it is lost,
// at the second all.
constexpr float kShinyBegin = 0.15F, kShinyEnd = 0.6F;
// The light that comes back, as albedo times the cosine of the angle by the squared distance
// (1/m^2): below the first all is lost, above the second nothing. Infrared sees more in dark wood
// and cloth than the eye does, so that only what is nearly black is lost.
constexpr float kFaintEnd = 0.0008F, kFaintBegin = 0.003F;
constexpr float kGrazingCosine = 0.1F;
// Losses come in patches of about this size, since disparity is found in windows.
constexpr int kCell_px = 4;

class Measurement {
 public:
  Measurement(const RenderedFrame& frame, const geometry::PinholeCamera& camera,
              const image::Image<Eigen::Vector2f>& rays, const SensorOptions& options,
              std::uint64_t index)
      : frame_(frame), camera_(camera), rays_(rays), options_(options), index_(index) {
    if (options.lost_surfaces) draw_cells();
  }

  void measure_row(int y, std::span<std::uint16_t> measured) const {
    RandomStream random(options_.seed, {index_, static_cast<std::uint64_t>(y), kPixelStream});
    std::vector<bool> is_shadowed(measured.size(), false);
    if (options_.projector_shadow) is_shadowed = shadow_of_row(y);
    std::vector<bool> is_edge(measured.size(), false);
    if (options_.edge_jitter) is_edge = edges_of_row(y);
    for (int x = 0; x < camera_.width; ++x) {
      const Eigen::Vector2i seen =
          is_edge[static_cast<std::size_t>(x)] ? jittered({x, y}, random) : Eigen::Vector2i(x, y);
      const float exact_m = frame_.depth_m.at(seen.x(), seen.y());
      const bool is_lost = exact_m <= 0 || depth_at(x, y) <= 0 ||
                           is_shadowed[static_cast<std::size_t>(x)] ||
                           (options_.lost_surfaces && is_lost_surface(x, y, random));
      measured[static_cast<std::size_t>(x)] = is_lost ? 0 : units_of(spoilt(exact_m, random));
    }
  }

 private:
  [[nodiscard]] float depth_at(int x, int y) const { return frame_.depth_m.at(x, y); }

  // One number in [0, 1) a patch of the image.
  void draw_cells() {
    cells_ = image::Image<float>(camera_.width / kCell_px + 3, camera_.height / kCell_px + 3);
    RandomStream random(options_.seed, {index_, kCellStream});
    for (float& cell : cells_.pixels()) cell = static_cast<float>(random.uniform());
  }

  // What the projector does not see because something nearer stands before it. Along a row the
  // pattern is seen shifted by the disparity, and what is seen by both keeps its order.
  [[nodiscard]] std::vector<bool> shadow_of_row(int y) const {
    const auto shift_px_m = static_cast<float>(kBaseline_m * camera_.fx);
    constexpr float kTolerance_px = 0.5F;
    std::vector<bool> is_shadowed(static_cast<std::size_t>(camera_.width), false);
    float leftmost_px = std::numeric_limits<float>::max();
    for (int x = camera_.width - 1; x >= 0; --x) {
      const float depth_m = depth_at(x, y);
      if (depth_m <= 0) continue;
      const float projector_px = static_cast<float>(x) - shift_px_m / depth_m;
      is_shadowed[static_cast<std::size_t>(x)] = projector_px > leftmost_px + kTolerance_px;
      leftmost_px = std::min(leftmost_px, projector_px);
    }
    return is_shadowed;
  }

  // Where the depth of a row's pixels jumps to that of one of their eight neighbours.
  [[nodiscard]] std::vector<bool> edges_of_row(int y) const {
    const auto width = static_cast<std::size_t>(camera_.width);
    std::vector<float> least(width, std::numeric_limits<float>::infinity()), most(width, 0);
    for (int row = std::max(0, y - 1); row <= std::min(camera_.height - 1, y + 1); ++row) {
      const std::span<const float> depths = frame_.depth_m.row(row);
      for (std::size_t x = 0; x < width; ++x) {
        least[x] = std::min(least[x], depths[x]);
        most[x] = std::max(most[x], depths[x]);
      }
    }
    std::vector<bool> is_edge(width);
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t left = x > 0 ? x - 1 : x, right = std::min(x + 1, width - 1);
      const float depth_m = frame_.depth_m.row(y)[x];
      const float nearest = std::min({least[left], least[x], least[right]});
      const float farthest = std::max({most[left], most[x], most[right]});
      is_edge[x] = std::max(farthest - depth_m, depth_m - nearest) > kEdgeShare * depth_m;
    }
    return is_edge;
  }

  // The pixel whose depth is found at a pixel near an edge.
  [[nodiscard]] Eigen::Vector2i jittered(const Eigen::Vector2i& pixel, RandomStream& random) const {
    const Eigen::Vector2d jitter(random.normal(), random.normal());
    const Eigen::Vector2i moved =
        pixel + (kEdgeJitter_px * jitter).array().round().matrix().cast<int>();
    return {std::clamp(moved.x(), 0, camera_.width - 1),
            std::clamp(moved.y(), 0, camera_.height - 1)};
  }

  [[nodiscard]] Eigen::Vector3f point_at(int x, int y) const {
    return depth_at(x, y) * rays_.at(x, y).homogeneous();
  }

  // The difference to the neighbour on the side where the surface goes on.
  [[nodiscard]] Eigen::Vector3f step(int x, int y, int dx, int dy) const {
    const auto difference = [&](int sign) -> Eigen::Vector3f {
      const int nx = x + sign * dx, ny = y + sign * dy;
      if (!frame_.depth_m.contains(nx, ny) || depth_at(nx, ny) <= 0) {
        return Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
      }
      return static_cast<float>(sign) * (point_at(nx, ny) - point_at(x, y));
    };
    const Eigen::Vector3f forward = difference(1), backward = difference(-1);
    return forward.squaredNorm() <= backward.squaredNorm() ? forward : backward;
  }

  // Of the angle at which a pixel's surface is seen; 1 where it cannot be told.
  [[nodiscard]] float cosine_at(int x, int y) const {
    const Eigen::Vector3f normal = step(x, y, 1, 0).cross(step(x, y, 0, 1));
    if (!normal.allFinite() || normal.squaredNorm() == 0) return 1;
    const Eigen::Vector3f sight = rays_.at(x, y).homogeneous();
    return std::abs(normal.dot(sight)) / (normal.norm() * sight.norm());
  }

  // How likely the pattern is lost on what a pixel sees.
  [[nodiscard]] float loss_at(int x, int y) const {
    const float depth_m = depth_at(x, y);
    const float cosine = cosine_at(x, y);
    const float light = frame_.albedo.at(x, y) * cosine / (depth_m * depth_m);
    const float shiny = smooth_step(kShinyBegin, kShinyEnd, frame_.specularity.at(x, y));
    const float faint = 1 - smooth_step(kFaintEnd, kFaintBegin, light);
    const float grazing = 1 - smooth_step(0.5F * kGrazingCosine, kGrazingCosine, cosine);
    return std::max({shiny, faint, grazing});
  }

  // Asked of pixels that see something.
  [[nodiscard]] bool is_lost_surface(int x, int y, RandomStream& random) const {
    // The patches have ragged borders.
    const auto ragged = [&](int pixel) {
      return (pixel + static_cast<int>(random.index(kCell_px))) / kCell_px;
    };
    const int cell_x = ragged(x), cell_y = ragged(y);
    return cells_.at(cell_x, cell_y) < loss_at(x, y);
  }

  // The distance with the error of its disparity.
  [[nodiscard]] double spoilt(double exact_m, RandomStream& random) const {
    if (!options_.depth_noise && !options_.depth_quantization) return exact_m;
    double disparity_px = kDisparity_px_m / exact_m;
    if (options_.depth_noise) {
      disparity_px += kDisparity_px_m * options_.depth_noise_m * random.normal();
    }
    if (options_.depth_quantization) {
      disparity_px = kDisparityStep_px * std::round(disparity_px / kDisparityStep_px);
    }
    return disparity_px > 0 ? kDisparity_px_m / disparity_px : 0;
  }

  [[nodiscard]] std::uint16_t units_of(double depth_m) const {
    if (options_.limited_range && (depth_m < options_.nearest_m || depth_m > options_.farthest_m)) {
      return 0;
    }
    const double units = std::round(depth_m * camera_.depth_units_per_metre);
    return units <= std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(units)
                                                              : 0;
  }

  const RenderedFrame& frame_;
  const geometry::PinholeCamera& camera_;
  const image::Image<Eigen::Vector2f>& rays_;
  const SensorOptions& options_;
  std::uint64_t index_;
  image::Image<float> cells_;
};

}  // namespace

image::DepthImage measure_depth(const RenderedFrame& frame, const geometry::PinholeCamera& camera,
                                const image::Image<Eigen::Vector2f>& rays,
                                const SensorOptions& options, std::uint64_t index,
                                ThreadPool& pool) {
  image::DepthImage depth(camera.width, camera.height);
  const Measurement measurement(frame, camera, rays, options, index);
  pool.parallel_for(static_cast<std::size_t>(camera.height), [&](std::size_t y) {
    const int row = static_cast<int>(y);
    measurement.measure_row(row, depth.row(row));
  });
  return depth;
}

}  // namespace roomwise::simulation
