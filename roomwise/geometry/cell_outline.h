#pragma once

#include <Eigen/Core>
#include <vector>

namespace roomwise::geometry {

// A set of cells of a grid: has[row * columns + column]. Cell (column, row) is the square from
// (column, row) to (column + 1, row + 1).
struct CellSet {
  int columns = 0;
  int rows = 0;
  std::vector<bool> has;

  // False outside the grid.
  [[nodiscard]] bool at(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows &&
           has[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column)];
  }
};

// Corners of cells, each once. No two edges that follow each other are on one line.
using CellRing = std::vector<Eigen::Vector2i>;

// Cells that hang together by their sides. The outer ring goes counter-clockwise (x along columns,
// y along rows), those of holes clockwise. No ring passes through a corner twice; two may touch in
// one.
struct CellPolygon {
  CellRing outer;
  std::vector<CellRing> holes;
};

// The outlines of the cells, in the order of their first cell (by row, then by column). Linear in
// the size of the grid.
[[nodiscard]] std::vector<CellPolygon> cell_outlines(const CellSet& cells);

}  // namespace roomwise::geometry
