#include "roomwise/objects/proposals/cell_components.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>

#include "roomwise/base/disjoint_sets.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3f;

constexpr int kGap_cells = 2;
constexpr std::size_t kFewestCells = 12;

// Which cells are near each other, by index: a gap of one between them counts for nothing, since
// from afar, or at a slant, pictures show fewer points of a surface than it has cells.
using Link = std::pair<std::size_t, std::size_t>;
std::vector<Link> links_between(const std::vector<LevelCell>& cells) {
  std::vector<Link> links;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const VoxelKey neighbor : cube_neighbors(cells[i].key, kGap_cells)) {
      if (neighbor < cells[i].key) continue;  // it looked here
      const auto at = std::ranges::lower_bound(cells, neighbor, {}, &LevelCell::key);
      if (at == cells.end() || at->key != neighbor) continue;
      links.emplace_back(i, static_cast<std::size_t>(at - cells.begin()));
    }
  }
  return links;
}

// The pieces into which the cells above a height fall.
std::vector<Component> pieces_above(const std::vector<LevelCell>& cells,
                                    const std::vector<Link>& links, double height_m) {
  DisjointSets sets(cells.size());
  const auto is_above = [&](std::size_t i) { return cells[i].height_m() >= height_m; };
  for (const auto& [a, b] : links) {
    if (is_above(a) && is_above(b)) sets.join(a, b);
  }
  std::map<std::size_t, Component> of_set;  // known by its lowest: in the order of the cells
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (is_above(i)) of_set[sets.find(i)].push_back(i);
  }
  std::vector<Component> components;
  for (auto& [set, component] : of_set) {
    if (component.size() >= kFewestCells) components.push_back(std::move(component));
  }
  return components;
}

}  // namespace

Column column_of(const Vector3f& middle) {
  return {static_cast<int>(std::floor(middle.x() / kLevelCell_m)),
          static_cast<int>(std::floor(middle.y() / kLevelCell_m))};
}

std::vector<Column> columns_about(const Column& column, int reach) {
  std::vector<Column> columns;
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      columns.emplace_back(column.first + dx, column.second + dy);
    }
  }
  return columns;
}

bool is_mostly_in(const Component& component, const Component& other) {
  constexpr double kMax = 0.7;
  if (static_cast<double>(other.size()) < kMax * static_cast<double>(component.size()))
    return false;
  Component both;
  std::ranges::set_intersection(component, other, std::back_inserter(both));
  return static_cast<double>(both.size()) > kMax * static_cast<double>(component.size());
}

std::vector<Component> components_above(const std::vector<LevelCell>& cells) {
  constexpr double kLowest_m = 0.1, kHighest_m = 1.6, kStep_m = 0.1;
  constexpr int kHeights = static_cast<int>((kHighest_m - kLowest_m) / kStep_m + 1.5);
  const std::vector<Link> links = links_between(cells);
  std::vector<Component> components;
  for (int i = 0; i < kHeights; ++i) {
    for (Component& component : pieces_above(cells, links, kLowest_m + i * kStep_m)) {
      const bool is_known = std::ranges::any_of(
          components, [&](const Component& lower) { return is_mostly_in(lower, component); });
      if (!is_known) components.push_back(std::move(component));
    }
  }
  return components;
}

}  // namespace roomwise::objects
