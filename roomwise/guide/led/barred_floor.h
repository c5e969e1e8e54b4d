#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/guide/places/places.h"

namespace roomwise::guide {

// Where somebody came upon what the map does not know, m, and until when that counts.
struct BarredPlace {
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();
  double radius_m = 0;
  TimestampNs until_ns = 0;
};

// What was come upon may stay, as a chair does, or go, as people do: so long it counts after it was
// found last, s. Most walks through a home are over by then, and so is the way back.
constexpr double kBarred_s = 300;

// The map's floor as somebody found it who is led over it: what they came upon counts as occupied
// for a while.
class BarredFloor {
 public:
  // The map's, which must outlive it; null: none is known, and nothing may be barred on it.
  // `known`: what was found on it before.
  explicit BarredFloor(const fusion::FloorGrid* map, std::vector<BarredPlace> known = {});

  [[nodiscard]] const fusion::FloorGrid* grid() const { return barred_ ? &*barred_ : map_; }
  // What a cane found and no camera sees: so broad across the way, from where it touched it.
  void bar_ahead(const Pose& pose, double radius_m, TimestampNs now_ns);
  // What depth shows and the map does not know: the middles of squares.
  void bar_seen(std::span<const Eigen::Vector2d> obstacles, TimestampNs now_ns);
  // What was found too long ago counts no more.
  void forget_old(TimestampNs now_ns);
  // What barred them may have gone.
  void clear();
  [[nodiscard]] const std::vector<BarredPlace>& places() const { return places_; }

  // That they came no further, about where they stand now: the tries there.
  void count_try(const Pose& pose);
  [[nodiscard]] bool was_barred_at(const Pose& pose) const;
  [[nodiscard]] int tries() const { return tries_; }

  // How much must be free to the sides of who stands there: so much, or what is now.
  [[nodiscard]] double narrow_m_at(const Eigen::Vector2d& here, double narrow_radius_m) const;
  // 1: to the left, -1: to the right; there is more room ahead.
  [[nodiscard]] double freer_side(const Pose& pose) const;

 private:
  void mark_places();

  const fusion::FloorGrid* map_;
  std::vector<BarredPlace> places_;
  std::optional<fusion::FloorGrid> barred_;
  std::optional<Eigen::Vector2d> tried_at_;
  int tries_ = 0;  // there
};

}  // namespace roomwise::guide
