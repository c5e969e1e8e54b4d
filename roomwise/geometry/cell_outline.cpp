#include "roomwise/geometry/cell_outline.h"

#include <array>
#include <cstdint>
#include <map>
#include <utility>

namespace roomwise::geometry {
namespace {

// East, north, west, south: a turn to the left is the next.
const std::array<Eigen::Vector2i, 4> kSteps{
    {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)}};

// The cell to the left of the edge that leaves a corner in a direction.
Eigen::Vector2i left_cell(const Eigen::Vector2i& corner, std::size_t direction) {
  static const std::array<Eigen::Vector2i, 4> kLeft{{Eigen::Vector2i(0, 0), Eigen::Vector2i(-1, 0),
                                                     Eigen::Vector2i(-1, -1),
                                                     Eigen::Vector2i(0, -1)}};
  return corner + kLeft[direction];
}

std::int64_t twice_area(const CellRing& ring) {
  std::int64_t area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2i& a = ring[i];
    const Eigen::Vector2i& b = ring[(i + 1) % ring.size()];
    area += std::int64_t{a.x()} * b.y() - std::int64_t{b.x()} * a.y();
  }
  return area;
}

// A corner that the outline passes, and the cell on its left from there on.
struct Passed {
  Eigen::Vector2i corner;
  Eigen::Vector2i cell;
};

CellRing without_corners_on_lines(const std::vector<Passed>& passed) {
  CellRing ring;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    const Eigen::Vector2i& at = passed[i].corner;
    const Eigen::Vector2i in = at - passed[(i + passed.size() - 1) % passed.size()].corner;
    const Eigen::Vector2i out = passed[(i + 1) % passed.size()].corner - at;
    if (in != out) ring.push_back(at);
  }
  return ring;
}

class OutlineTracer {
 public:
  explicit OutlineTracer(const CellSet& cells)
      : cells_(cells), is_traced_(4 * corners()), label_(cells.has.size(), -1) {}

  std::vector<CellPolygon> trace() {
    for (int row = 0; row < cells_.rows; ++row) {
      for (int column = 0; column < cells_.columns; ++column) label_from({column, row});
    }
    for (int row = 0; row <= cells_.rows; ++row) {
      for (int column = 0; column <= cells_.columns; ++column) {
        for (std::size_t direction = 0; direction < 4; ++direction) {
          trace_from({column, row}, direction);
        }
      }
    }
    return std::move(polygons_);
  }

 private:
  [[nodiscard]] std::size_t corners() const {
    return static_cast<std::size_t>(cells_.rows + 1) * static_cast<std::size_t>(cells_.columns + 1);
  }
  [[nodiscard]] bool has(const Eigen::Vector2i& cell) const {
    return cells_.at(cell.x(), cell.y());
  }
  [[nodiscard]] std::size_t index(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(cells_.columns) +
           static_cast<std::size_t>(cell.x());
  }
  // Whether an edge of the outline leaves the corner: a cell of the set on its left, none on its
  // right.
  [[nodiscard]] bool is_edge(const Eigen::Vector2i& corner, std::size_t direction) const {
    const Eigen::Vector2i left = left_cell(corner, direction);
    const Eigen::Vector2i right = left + kSteps[(direction + 3) % 4];
    return has(left) && !has(right);
  }
  [[nodiscard]] std::vector<bool>::reference traced(const Eigen::Vector2i& corner,
                                                    std::size_t direction) {
    return is_traced_[4 * (static_cast<std::size_t>(corner.y()) *
                               static_cast<std::size_t>(cells_.columns + 1) +
                           static_cast<std::size_t>(corner.x())) +
                      direction];
  }

  // Gives the cells that hang together with this one a polygon of their own.
  void label_from(const Eigen::Vector2i& first) {
    if (!has(first) || label_[index(first)] >= 0) return;
    const int label = static_cast<int>(polygons_.size());
    polygons_.emplace_back();
    std::vector<Eigen::Vector2i> open{first};
    label_[index(first)] = label;
    while (!open.empty()) {
      const Eigen::Vector2i cell = open.back();
      open.pop_back();
      for (const Eigen::Vector2i& step : kSteps) {
        const Eigen::Vector2i next = cell + step;
        if (!has(next) || label_[index(next)] >= 0) continue;
        label_[index(next)] = label;
        open.push_back(next);
      }
    }
  }

  void trace_from(const Eigen::Vector2i& first, std::size_t first_direction) {
    if (!is_edge(first, first_direction) || traced(first, first_direction)) return;
    std::vector<Passed> passed;
    std::map<std::pair<int, int>, std::size_t> when;  // a corner was passed, in `passed`
    Eigen::Vector2i corner = first;
    std::size_t direction = first_direction;
    do {
      // Where the outline comes back to a corner, what it went round since is a ring of its own.
      const auto key = std::pair(corner.x(), corner.y());
      if (const auto found = when.find(key); found != when.end()) {
        const std::size_t before = found->second;  // this corner itself is among those forgotten
        take({passed.begin() + static_cast<std::ptrdiff_t>(before), passed.end()});
        for (std::size_t i = before; i < passed.size(); ++i) {
          when.erase({passed[i].corner.x(), passed[i].corner.y()});
        }
        passed.resize(before);
      }
      when[key] = passed.size();
      passed.push_back({corner, left_cell(corner, direction)});
      traced(corner, direction) = true;
      corner += kSteps[direction];
      // To the left first: it stays with its cell where two touch by their corners.
      for (const std::size_t turn : {1U, 0U, 3U}) {
        if (!is_edge(corner, (direction + turn) % 4)) continue;
        direction = (direction + turn) % 4;
        break;
      }
    } while (corner != first || direction != first_direction);
    take(passed);
  }

  void take(const std::vector<Passed>& passed) {
    CellRing ring = without_corners_on_lines(passed);
    CellPolygon& polygon = polygons_[static_cast<std::size_t>(label_[index(passed.front().cell)])];
    if (twice_area(ring) > 0) {
      polygon.outer = std::move(ring);
    } else {
      polygon.holes.push_back(std::move(ring));
    }
  }

  const CellSet& cells_;
  std::vector<bool> is_traced_;
  std::vector<int> label_;  // of each cell: index into polygons_
  std::vector<CellPolygon> polygons_;
};

}  // namespace

std::vector<CellPolygon> cell_outlines(const CellSet& cells) {
  return OutlineTracer(cells).trace();
}

}  // namespace roomwise::geometry
