#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/simulation/emitters.h"
#include "roomwise/simulation/scene.h"

namespace roomwise::simulation {

// A point on a surface where light is gathered.
struct LightPoint {
  Eigen::Vector3f position;  // a hair above the surface
  Eigen::Vector3f normal;
  float openness = 1;  // the share of short rays that get away
};

// The share of short rays from a point that get away. Less than kLeastOpenness: another surface
// lies right on it, or it is inside a board.
[[nodiscard]] float openness_of(const RayCaster& rays, const LightPoint& point, std::uint32_t seed);
constexpr int kOpennessRays = 12;
constexpr float kLeastOpenness = 0.25F;

// The points of furniture and fittings. They are spread evenly over all triangles, on both sides,
// but not where another surface lies right on them: what is buried is never seen, and its darkness
// must not spread to what is. The light at a triangle's corner is blended from the points around
// that face about the same way.
class CornerPoints {
 public:
  CornerPoints(const Scene& scene, ThreadPool& pool);

  [[nodiscard]] const std::vector<LightPoint>& points() const { return points_; }
  [[nodiscard]] std::uint64_t rays() const { return rays_; }  // traced to place the points

  // The illuminance of the point that stands for the middle of a triangle. side: 0 front, 1 back.
  [[nodiscard]] Eigen::Vector3f at_middle(const std::vector<Flux>& fluxes, std::uint32_t triangle,
                                          int side) const;
  // The illuminance at a corner with the corner's own normal, front and back.
  [[nodiscard]] std::array<Eigen::Vector3f, 2> at_corner(const std::vector<Flux>& fluxes,
                                                         std::uint32_t corner) const;
  // A point near another, and how much its light tells about the other's by their places alone.
  struct Neighbor {
    std::uint32_t point;
    float weight;
  };
  // Appends a point's neighbors, itself among them.
  void find_neighbors(std::size_t point, std::vector<Neighbor>& neighbors) const;
  // A point's light with its noise averaged away over the neighbors whose light differs little.
  [[nodiscard]] Flux smoothed(const std::vector<Flux>& fluxes, std::size_t point,
                              std::span<const Neighbor> neighbors, float tolerance) const;

 private:
  static constexpr std::uint32_t kNone = ~0U;
  using CellIndex = std::array<int, 3>;
  struct Cell {
    std::uint64_t key;
    std::uint32_t first, count;  // of points
  };
  // A corner of a triangle outside patches.
  struct Corner {
    bool is_used = false;
    std::uint16_t object = 0;
    Eigen::Vector3f plane_normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f inside;  // just inside its triangle
    // The points of triangles that it belongs to, for where blending finds none. By side.
    std::array<std::uint32_t, 2> own_point{kNone, kNone};
  };
  [[nodiscard]] Eigen::Vector3f corner_normal(std::uint32_t corner, int side) const;
  template <typename Visit>
  void visit_around(std::uint16_t object, const Eigen::Vector3f& position,
                    const Visit& visit) const;
  [[nodiscard]] float weight_of(const LightPoint& point, float facing,
                                const Eigen::Vector3f& position,
                                const Eigen::Vector3f& normal) const;
  void note_corners();
  void measure_openness(ThreadPool& pool);
  void place_points();
  std::uint32_t add_point(std::uint16_t object, const LightPoint& point);
  void index_cells();

  const Scene& scene_;
  std::vector<Corner> corners_;                         // by index of position
  std::array<std::vector<float>, 2> openness_;          // of a triangle's middle
  std::array<std::vector<std::uint32_t>, 2> point_of_;  // of a triangle's middle
  std::vector<LightPoint> points_;
  std::vector<std::uint16_t> point_object_;
  std::vector<Cell> cells_;                // in the order of keys
  std::vector<std::uint32_t> first_cell_;  // of every object
  std::uint64_t rays_ = 0;
};

}  // namespace roomwise::simulation
