#include "roomwise/geometry/distance_transform.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace roomwise::geometry {
namespace {

// Squared distances along one line of cells to the nearest cell, where `line` holds what each cell
// has from the other direction: the lower envelope of parabolas.
void transform_line(std::vector<double>& line) {
  const int count = static_cast<int>(line.size());
  std::vector<int> lowest(line.size());
  std::vector<double> from(line.size() + 1);
  const auto at = [&](int i) { return line[static_cast<std::size_t>(i)]; };
  const auto meeting = [&](int a, int b) {
    return (at(b) + static_cast<double>(b) * b - at(a) - static_cast<double>(a) * a) /
           (2.0 * (b - a));
  };
  int parabolas = 0;
  from[0] = -kFarFromAll;
  from[1] = kFarFromAll;
  for (int i = 1; i < count; ++i) {
    double start = meeting(lowest[static_cast<std::size_t>(parabolas)], i);
    while (start <= from[static_cast<std::size_t>(parabolas)]) {
      --parabolas;
      start = meeting(lowest[static_cast<std::size_t>(parabolas)], i);
    }
    ++parabolas;
    lowest[static_cast<std::size_t>(parabolas)] = i;
    from[static_cast<std::size_t>(parabolas)] = start;
    from[static_cast<std::size_t>(parabolas) + 1] = kFarFromAll;
  }
  std::vector<double> result(line.size());
  int parabola = 0;
  for (int i = 0; i < count; ++i) {
    while (from[static_cast<std::size_t>(parabola) + 1] < i) ++parabola;
    const int source = lowest[static_cast<std::size_t>(parabola)];
    result[static_cast<std::size_t>(i)] =
        static_cast<double>(i - source) * (i - source) + at(source);
  }
  line = std::move(result);
}

}  // namespace

std::vector<double> squared_distances(std::vector<double> cells, int columns, int rows) {
  const auto index = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  };
  std::vector<double> line(static_cast<std::size_t>(rows));
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      line[static_cast<std::size_t>(row)] = cells[index(column, row)];
    }
    transform_line(line);
    for (int row = 0; row < rows; ++row) {
      cells[index(column, row)] = line[static_cast<std::size_t>(row)];
    }
  }
  line.resize(static_cast<std::size_t>(columns));
  for (int row = 0; row < rows; ++row) {
    const auto first = cells.begin() + static_cast<std::ptrdiff_t>(index(0, row));
    std::copy_n(first, columns, line.begin());
    transform_line(line);
    std::ranges::copy(line, first);
  }
  return cells;
}

}  // namespace roomwise::geometry
