#pragma once

#include <optional>
#include <span>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/guide/places/places.h"

namespace roomwise::guide {

// The map's floor as somebody found it who is led over it: what they came upon counts as occupied.
class BarredFloor {
 public:
  // The map's, which must outlive it; null: none is known, and nothing may be barred on it.
  explicit BarredFloor(const fusion::FloorGrid* map) : map_(map) {}

  [[nodiscard]] const fusion::FloorGrid* grid() const { return barred_ ? &*barred_ : map_; }
  // What a cane found and no camera sees: so broad across the way, from where it touched it.
  void bar_ahead(const Pose& pose, double radius_m);
  // What depth shows and the map does not know: the middles of squares.
  void bar_seen(std::span<const Eigen::Vector2d> obstacles);
  // What barred them may have gone.
  void clear() { barred_.reset(); }

  // That they came no further, about where they stand now: the tries there.
  void count_try(const Pose& pose);
  [[nodiscard]] bool was_barred_at(const Pose& pose) const;
  [[nodiscard]] int tries() const { return tries_; }

  // How much must be free to the sides of who stands there: so much, or what is now.
  [[nodiscard]] double narrow_m_at(const Eigen::Vector2d& here, double narrow_radius_m) const;
  // 1: to the left, -1: to the right; there is more room ahead.
  [[nodiscard]] double freer_side(const Pose& pose) const;

 private:
  void mark_occupied(std::span<const Eigen::Vector2d> middles, double radius_m);

  const fusion::FloorGrid* map_;
  std::optional<fusion::FloorGrid> barred_;
  std::optional<Eigen::Vector2d> tried_at_;
  int tries_ = 0;  // there
};

}  // namespace roomwise::guide
