#include "laboratory/simulation/walk/viewpoints.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/home/home_geometry.h"

namespace roomwise::simulation {
namespace {

constexpr double kNearest = 1.0, kFarthest = 2.4, kBest = 1.7;
constexpr double kTall = 1.2;  // hides what is behind it

bool is_worth_seeing(const PlacedObject& object) {
  constexpr double kFlat = 0.05;
  return object.stands_on || object.size_m.z() > kFlat;
}

double importance(const PlacedObject& object) {
  if (object.is_small) return 0.5;
  return object.is_movable && object.kind != "lamp" ? 1 : 3;
}

bool crosses(const Footprint& footprint, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  constexpr double kStep = 0.1;
  const int steps = std::max(1, static_cast<int>((to - from).norm() / kStep));
  for (int i = 0; i <= steps; ++i) {
    if (footprint.contains(from + (to - from) * i / steps)) return true;
  }
  return false;
}

class RoomViews {
 public:
  RoomViews(const HomeModel& home, std::size_t room, const FreeSpace& space,
            const std::vector<bool>& reachable, double radius_m)
      : home_(home) {
    for (std::size_t i = 0; i < home.objects.size(); ++i) {
      const PlacedObject& object = home.objects[i];
      if (object.room != room) continue;
      const Footprint footprint = footprint_of(object);
      if (footprint.top_m > kTall) tall_.push_back({i, footprint});
      if (is_worth_seeing(object)) targets_.push_back({i, footprint});
    }
    collect_places(home.rooms[room].interior, space, reachable, radius_m);
  }

  std::vector<Viewpoint> choose() {
    std::vector<Viewpoint> chosen;
    std::vector<double> best(targets_.size(), 0.0);
    const std::size_t most = places_.empty() ? 0 : 5;
    while (chosen.size() < most) {
      std::size_t winner = 0;
      double max_gain = 0;
      for (std::size_t p = 0; p < places_.size(); ++p) {
        double gain = 0;
        for (std::size_t t = 0; t < targets_.size(); ++t) {
          gain += std::max(0.0, quality(p, t) - best[t]) *
                  importance(home_.objects[targets_[t].object]);
        }
        if (gain <= max_gain + 1e-9) continue;
        max_gain = gain;
        winner = p;
      }
      constexpr double kWorthAStop = 1.6;
      if (max_gain < kWorthAStop && !chosen.empty()) break;
      chosen.push_back({places_[winner], {}});
      for (std::size_t t = 0; t < targets_.size(); ++t) {
        const double seen = quality(winner, t);
        if (seen <= best[t] + 0.05) continue;
        best[t] = seen;
        chosen.back().objects.push_back(targets_[t].object);
      }
      if (max_gain <= 0) break;  // nothing to see: one place to stand
    }
    return chosen;
  }

 private:
  struct Target {
    std::size_t object;
    Footprint footprint;
  };

  void collect_places(const Rectangle& interior, const FreeSpace& space,
                      const std::vector<bool>& reachable, double radius_m) {
    constexpr int kEvery = 3;  // cells
    for (const int every : {kEvery, 1}) {
      for (int row = 0; row < space.rows(); row += every) {
        for (int column = 0; column < space.columns(); column += every) {
          if (!reachable[static_cast<std::size_t>(row * space.columns() + column)]) continue;
          const Eigen::Vector2d place = space.cell_center(column, row);
          if (contains(interior, place) && space.clearance_m(column, row) >= radius_m) {
            places_.push_back(place);
          }
        }
      }
      if (!places_.empty()) break;
    }
    qualities_.assign(places_.size() * targets_.size(), -1.0F);
  }

  double quality(std::size_t place, std::size_t target) {
    float& known = qualities_[place * targets_.size() + target];
    if (known < 0) known = static_cast<float>(measure(places_[place], targets_[target]));
    return static_cast<double>(known);
  }

  // 1: seen well. Less: too near, too far, from behind. 0: not seen.
  [[nodiscard]] double measure(const Eigen::Vector2d& place, const Target& target) const {
    const Footprint& footprint = target.footprint;
    const Eigen::Vector2d to_place = place - footprint.center;
    const double distance = to_place.norm();
    if (distance < 0.3 || distance > 4) return 0;
    const PlacedObject& object = home_.objects[target.object];
    const auto hides = [&](const Target& other) {
      return other.object != target.object && object.stands_on != other.object &&
             other.footprint.bottom_m < kTall && crosses(other.footprint, place, footprint.center);
    };
    if (std::ranges::any_of(tall_, hides)) return 0;
    double quality = 1;
    if (distance < kNearest) quality *= 0.3 + 0.4 * distance / kNearest;
    if (distance > kFarthest) quality *= 0.6 * kFarthest / distance;
    quality *= 1 - 0.1 * std::abs(distance - kBest);
    const double frontal = facing(footprint.yaw_rad).dot(to_place) / distance;
    if (!object.is_small && frontal < 0.25) quality *= 0.5;
    return quality;
  }

  const HomeModel& home_;
  std::vector<Target> tall_, targets_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<float> qualities_;  // by place, then target; below 0: not measured
};

}  // namespace

std::vector<Viewpoint> choose_viewpoints(const HomeModel& home, std::size_t room,
                                         const FreeSpace& space, const std::vector<bool>& reachable,
                                         double radius_m) {
  return RoomViews(home, room, space, reachable, radius_m).choose();
}

}  // namespace roomwise::simulation
