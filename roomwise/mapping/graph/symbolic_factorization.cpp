#include "roomwise/mapping/graph/symbolic_factorization.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <iterator>

namespace roomwise::mapping {
namespace {

using Places = std::vector<std::uint32_t>;
constexpr std::uint32_t kNone = Front::kNone;

// By block: its place in an order of approximately minimum degree.
Places minimum_degree(std::size_t count, std::span<const BlockPair> pairs) {
  const auto size = static_cast<int>(count);
  std::vector<Eigen::Triplet<double, int>> entries;
  for (const auto& [a, b] : pairs) {
    entries.emplace_back(static_cast<int>(a), static_cast<int>(b), 1.0);
    entries.emplace_back(static_cast<int>(b), static_cast<int>(a), 1.0);
  }
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, 1.0);
  Eigen::SparseMatrix<double> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  Places place(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    place[static_cast<std::size_t>(order.indices()[static_cast<Eigen::Index>(i)])] = i;
  }
  return place;
}

// By column: the rows below the diagonal at which the matrix is not zero, ascending.
std::vector<Places> rows_below(const Places& place, std::span<const BlockPair> pairs) {
  std::vector<Places> rows(place.size());
  for (const auto& [a, b] : pairs) {
    const auto [column, row] = std::minmax({place[a], place[b]});
    rows[column].push_back(row);
  }
  for (Places& column : rows) {
    std::ranges::sort(column);
    column.erase(std::ranges::unique(column).begin(), column.end());
  }
  return rows;
}

// The elimination tree: by column, the first column that its elimination changes (Liu 1990).
Places elimination_tree(const std::vector<Places>& below) {
  const std::size_t count = below.size();
  std::vector<Places> left(count);  // by row, the columns at which it is not zero, ascending
  for (std::uint32_t column = 0; column < count; ++column) {
    for (const std::uint32_t row : below[column]) left[row].push_back(column);
  }
  Places parent(count, kNone);
  Places root(count, kNone);  // a short way up the tree so far
  for (std::uint32_t row = 0; row < count; ++row) {
    for (std::uint32_t column : left[row]) {
      while (column != kNone && column < row) {
        const std::uint32_t next = root[column];
        root[column] = row;
        if (next == kNone) parent[column] = row;
        column = next;
      }
    }
  }
  return parent;
}

// By column: its place when each column comes right after all that lie below it in the tree.
Places postorder(const Places& parent) {
  const std::size_t count = parent.size();
  std::vector<Places> children(count);
  Places open;
  for (auto column = static_cast<std::uint32_t>(count); column-- > 0;) {
    (parent[column] == kNone ? open : children[parent[column]]).push_back(column);
  }
  // Backwards: a parent, then its children from the last.
  Places place(count);
  auto next = static_cast<std::uint32_t>(count);
  std::ranges::reverse(open);
  while (!open.empty()) {
    const std::uint32_t column = open.back();
    open.pop_back();
    place[column] = --next;
    open.insert(open.end(), children[column].rbegin(), children[column].rend());
  }
  return place;
}

// A front of each column, with the rows that its children leave.
std::vector<Front> single_fronts(std::vector<Places> below, const Places& parent) {
  std::vector<Front> fronts(parent.size());
  for (std::uint32_t column = 0; column < parent.size(); ++column) {
    Front& front = fronts[column];
    front = {1, parent[column], {column}};
    front.rows.insert(front.rows.end(), below[column].begin(), below[column].end());
    if (front.parent == kNone) continue;
    Places& up = below[front.parent];
    Places both;
    std::set_union(up.begin(), up.end(), below[column].begin(), below[column].end(),
                   std::back_inserter(both));
    std::erase(both, front.parent);
    up = std::move(both);
  }
  return fronts;
}

// Joins fronts with their parents where that costs little arithmetic on zeros: few large fronts
// are quicker than many small ones.
std::vector<Front> amalgamate_fronts(std::vector<Front> single) {
  constexpr double kMaxZeros = 0.2;   // of the joined front's columns
  constexpr std::size_t kAlways = 3;  // columns that are joined whatever they cost
  std::vector<Front> fronts;
  std::vector<std::size_t> zeros;  // blocks of each front that are stored for nothing
  Places front_of(single.size());
  for (std::uint32_t column = 0; column < single.size(); ++column) {
    Front joined = std::move(single[column]);
    std::size_t joined_zeros = 0;
    // The front before may be a child; once it is joined, the one before that may be.
    while (!fronts.empty() && fronts.back().parent >= joined.rows.front() &&
           fronts.back().parent <= column) {
      const Front& child = fronts.back();
      const std::size_t columns = child.columns + joined.columns;
      const std::size_t rows = child.columns + joined.rows.size();
      const std::size_t more = child.columns * (rows - child.rows.size());
      const std::size_t all_zeros = zeros.back() + joined_zeros + more;
      const double stored = static_cast<double>(columns * (2 * rows - columns + 1)) / 2;
      if (columns > kAlways && static_cast<double>(all_zeros) > kMaxZeros * stored) break;
      joined.rows.insert(joined.rows.begin(), child.rows.begin(),
                         child.rows.begin() + child.columns);
      joined.columns = static_cast<std::uint32_t>(columns);
      joined_zeros = all_zeros;
      fronts.pop_back();
      zeros.pop_back();
    }
    fronts.push_back(std::move(joined));
    zeros.push_back(joined_zeros);
  }
  for (std::uint32_t i = 0; i < fronts.size(); ++i) {
    for (std::uint32_t k = 0; k < fronts[i].columns; ++k) front_of[fronts[i].rows[k]] = i;
  }
  for (Front& front : fronts) {
    if (front.parent != kNone) front.parent = front_of[front.parent];
  }
  return fronts;
}

}  // namespace

SymbolicFactorization analyze_pattern(std::size_t count, std::span<const BlockPair> pairs) {
  SymbolicFactorization plan;
  plan.place = minimum_degree(count, pairs);
  // Renumbering the tree's columns from below changes no fill and puts children beside parents.
  const Places later = postorder(elimination_tree(rows_below(plan.place, pairs)));
  for (std::uint32_t& place : plan.place) place = later[place];
  std::vector<Places> below = rows_below(plan.place, pairs);
  const Places parent = elimination_tree(below);
  plan.fronts = amalgamate_fronts(single_fronts(std::move(below), parent));
  return plan;
}

}  // namespace roomwise::mapping
