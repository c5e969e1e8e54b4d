#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace roomwise::simulation {

// A point on a surface where light is gathered.
struct LightPoint {
  Eigen::Vector3f position;  // a hair above the surface
  Eigen::Vector3f normal;
  float openness = 1;  // the share of short rays that get away
};

// Finds the points that tell of the light at a place. How much a point tells falls with its
// distance, faster across the place's plane than along it, since the light on another shelf is
// another; with the angle between the two surfaces; and where the point is hemmed in.
//
// The points of an object stand in columns over a level grid, each column sorted by height, so
// that few are looked at which tell nothing.
class LightPointIndex {
 public:
  struct Neighbor {
    std::uint32_t point;
    float weight;  // negative: it faces the other way, and tells of the surface's other side
  };

  LightPointIndex() = default;
  // The order in which the index wants its points: neighbors in space lie together in memory.
  [[nodiscard]] static std::vector<std::uint32_t> order_of(std::span<const LightPoint> points,
                                                           std::span<const std::uint16_t> objects);
  // The points in that order, and the object of each.
  LightPointIndex(std::span<const LightPoint> points, std::span<const std::uint16_t> objects);

  // Appends the points of an object that tell of the light at a place that faces along `normal`.
  void find(std::uint16_t object, const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
            std::vector<Neighbor>& found) const;

 private:
  // An object's columns: row after row along x, in each along y.
  struct Columns {
    int first_x = 0, first_y = 0, count_x = 0, count_y = 0;
    std::size_t offset = 0;  // of the first one in column_starts_
  };
  void weigh(std::size_t first, std::size_t end, const Eigen::Vector3f& position,
             const Eigen::Vector3f& normal, std::vector<Neighbor>& found) const;

  std::vector<Columns> columns_;              // by object
  std::vector<std::uint32_t> column_starts_;  // of every object's columns one more than it has
  std::array<std::vector<float>, 3> positions_, normals_;  // by axis, for eight at a time
  std::vector<float> openness_squared_;
};

}  // namespace roomwise::simulation
