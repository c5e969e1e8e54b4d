#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/light_point_index.h"
#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// The share of short rays from a point that get away. Less than kMinOpenness: another surface
// lies right on it, or it is inside a board.
[[nodiscard]] float openness_of(const RayCaster& rays, const LightPoint& point, std::uint32_t seed);
constexpr int kOpennessRays = 12;
constexpr float kMinOpenness = 0.25F;

// Which points are taken for one: same object, cell and facing, and about the same plane.
struct PlaceKey {
  std::uint64_t cell;
  std::int32_t facing, plane;
  auto operator<=>(const PlaceKey&) const = default;
};

// The points of furniture and fittings. They are spread evenly over all triangles, on both sides,
// but not where another surface lies right on them: what is buried is never seen, and its darkness
// must not spread to what is. The light at a triangle's corner is blended from the points around
// that face about the same way.
class CornerPoints {
 public:
  static constexpr std::uint32_t kNone = ~0U;

  CornerPoints(const Scene& scene, ThreadPool& pool);

  [[nodiscard]] const std::vector<LightPoint>& points() const { return points_; }
  [[nodiscard]] std::uint64_t rays() const { return rays_; }  // traced to place the points

  // The illuminance of the point that stands for the middle of a triangle. side: 0 front, 1 back.
  [[nodiscard]] Eigen::Vector3f at_middle(const std::vector<Flux>& fluxes, std::uint32_t triangle,
                                          int side) const;
  // Which points tell of a point's light, itself among them; appended.
  void find_neighbors(std::size_t point, std::vector<LightPointIndex::Neighbor>& neighbors) const;
  // What the light at a corner of a triangle outside patches is blended from, with the corner's own
  // normal: the front's takes the neighbors of positive weight, the back's the others.
  struct CornerSources {
    std::vector<LightPointIndex::Neighbor> neighbors;
    Eigen::Vector3f normal;  // of the front
    // For a side without neighbors; kNone where there is none.
    std::array<std::uint32_t, 2> own_point{kNone, kNone};
  };
  // False where no triangle outside patches has that corner. `sources` keeps its memory.
  bool find_sources(std::uint32_t corner, CornerSources& sources) const;

 private:
  // A corner of a triangle outside patches.
  struct Corner {
    bool is_used = false;
    std::uint16_t object = 0;
    Eigen::Vector3f plane_normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f inside;  // just inside its triangle
    // The points of triangles that it belongs to, for where blending finds none. By side.
    std::array<std::uint32_t, 2> own_point{kNone, kNone};
  };
  [[nodiscard]] Eigen::Vector3f corner_normal(std::uint32_t corner) const;
  void note_corners();
  // One side of a triangle, and the place that its middle is taken for.
  struct Side {
    PlaceKey place;
    std::uint32_t triangle;
    int side;  // 0 front, 1 back
    auto operator<=>(const Side&) const = default;
  };
  [[nodiscard]] std::vector<Side> sides_by_place() const;
  [[nodiscard]] std::optional<LightPoint> point_of_place(std::span<const Side> sides,
                                                         std::uint64_t& rays) const;
  void place_points(ThreadPool& pool);
  std::uint32_t add_point(std::uint16_t object, const LightPoint& point);
  void index_points();

  const Scene& scene_;
  std::vector<Corner> corners_;                         // by index of position
  std::array<std::vector<std::uint32_t>, 2> point_of_;  // of a triangle's middle
  std::vector<LightPoint> points_;
  std::vector<std::uint16_t> point_object_;
  LightPointIndex index_;
  std::uint64_t rays_ = 0;
};

}  // namespace roomwise::simulation
