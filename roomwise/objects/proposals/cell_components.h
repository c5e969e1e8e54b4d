#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {

constexpr float kLevelCell_m = 0.05F;

// A place of the gravity-aligned frame: x and y along the floor, z the height above it.
struct LevelCell {
  VoxelKey key = 0;        // by kLevelCell_m
  Eigen::Vector3f middle;  // of the cell, m
  int shown = 0;           // by so many key-frames
  [[nodiscard]] double height_m() const { return static_cast<double>(middle.z()); }
};

// What lies above one cell of the floor.
using Column = std::pair<int, int>;
[[nodiscard]] Column column_of(const Eigen::Vector3f& middle);
// The columns of the square that reaches so many from this one to each side, with it.
[[nodiscard]] std::vector<Column> columns_about(const Column& column, int reach);

// Cells that are one, by their indices, ascending. The functions below take cells in the order of
// their keys.
using Component = std::vector<std::size_t>;
// Seven tenths of its cells.
[[nodiscard]] bool is_mostly_in(const Component& component, const Component& other);

// The pieces of twelve cells or more into which the cells above each height fall, from 0.1 to 1.6 m
// every 0.1 m; those of lower heights first, without those that hold most of one from lower down.
[[nodiscard]] std::vector<Component> components_above(const std::vector<LevelCell>& cells);

}  // namespace roomwise::objects
