#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace roomwise {

// Elements 0, 1, 2, ... that are joined into sets (union-find); each is a set of its own at first.
// A set is known by its lowest element.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  // One element more.
  std::size_t add() {
    parent_.push_back(parent_.size());
    return parent_.back();
  }

  // The lowest element of the element's set.
  std::size_t find(std::size_t element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];
      element = parent_[element];
    }
    return element;
  }
  // Whether they were apart.
  bool join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({find(a), find(b)});
    parent_[high] = low;
    return low != high;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace roomwise
