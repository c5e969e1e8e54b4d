#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "roomwise/objects/world_sight.h"

namespace roomwise::objects {

constexpr float kLevelCell_m = 0.05F;

// A place of the level frame: x and y along the floor, z the height above it.
struct LevelCell {
  VoxelKey key = 0;        // by kLevelCell_m
  Eigen::Vector3f middle;  // of the cell, m
  int shown = 0;           // by so many key-frames
  [[nodiscard]] double height_m() const { return static_cast<double>(middle.z()); }
};

// What lies above one cell of the floor.
using Column = std::pair<int, int>;
[[nodiscard]] Column column_of(const Eigen::Vector3f& middle);

// Cells that are one, by their indices, ascending. The functions below take cells in the order of
// their keys.
using Piece = std::vector<std::size_t>;
[[nodiscard]] bool is_mostly_in(const Piece& piece, const Piece& other);

// The pieces into which the cells above each height fall, from 0.1 m on every 0.1 m; those of lower
// heights first, without those that are most of one from lower down.
[[nodiscard]] std::vector<Piece> pieces_apart(const std::vector<LevelCell>& cells);

// What stands under a surface of one height, up to a step: what touches something higher is a piece
// of this kind, and never one that stands apart. Under a table's top only the top is: a column has
// a surface wherever nothing is seen for 0.3 m above.
[[nodiscard]] std::vector<Piece> pieces_of_one_height(const std::vector<LevelCell>& cells);

}  // namespace roomwise::objects
