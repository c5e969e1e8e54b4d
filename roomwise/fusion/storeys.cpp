#include "roomwise/fusion/storeys.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace roomwise::fusion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSag_m = 0.1;         // a map's floor may lie so much lower
constexpr double kPerson_m = 1.9;      // as FloorGridOptions has it
constexpr double kSameFloor_m = 0.06;  // likewise: what differs less is the same floor
// A camera is held over a knee and under the top of a head.
constexpr double kCameraFrom_m = 0.3, kCameraTo_m = kPerson_m;
constexpr double kBody_m = 0.25;      // a body's radius: what lies under it
constexpr double kMinWalked_m = 2.0;  // three strides on one level: more than a landing of a flight
constexpr double kStand_m = 0.45;     // a stride's half from an edge, and the length of a foot
// Steps that people build: building codes allow 14 to 20 cm, old houses have 12 to 23.
constexpr double kMinRise_m = 0.12, kMaxRise_m = 0.23;
constexpr double kCell_m = 0.05;
// Where a walk was lost for a while, nobody knows where it led.
constexpr double kLongestGap_m = 1.0;

// ---- what lies under a walk ----

// The places of a surface that face up and lie near a walk, found by their place on the floor.
class LevelSurface {
 public:
  explicit LevelSurface(std::span<const CameraPath> paths) {
    for (const CameraPath& path : paths) {
      for (const Vector3d& camera : path)
        visit_cells(camera.head<2>(), kBody_m, [&](const Cell& cell) { cells_[cell]; });
    }
  }

  void add(const MeshPiece& piece) {
    constexpr float kMinCosine = 0.95F;  // 18 degrees
    for (std::size_t i = 0; i < piece.own; ++i) {
      if (piece.mesh.normals[i].z() < kMinCosine) continue;
      const Eigen::Vector3f& place = piece.mesh.vertices[i];
      const auto cell = cells_.find(cell_of(place.head<2>().cast<double>()));
      if (cell != cells_.end()) cell->second.push_back(place);
    }
  }

  // What a person with a camera there stands on: the height that most of the surface has.
  [[nodiscard]] std::optional<double> ground_m(const Vector3d& camera) const {
    std::vector<double> heights;
    visit_cells(camera.head<2>(), kBody_m, [&](const Cell& cell) {
      for (const Eigen::Vector3f& one : cells_.at(cell)) {
        const Vector3d place = one.cast<double>();
        if ((place.head<2>() - camera.head<2>()).squaredNorm() > kBody_m * kBody_m) continue;
        const double below_m = camera.z() - place.z();
        if (below_m >= kCameraFrom_m && below_m <= kCameraTo_m) heights.push_back(place.z());
      }
    });
    constexpr std::size_t kFewest = 10;  // vertices: 40 cm^2 at 2 cm
    if (heights.size() < kFewest) return std::nullopt;
    std::ranges::sort(heights);
    std::size_t most = 0, best = 0;
    for (std::size_t first = 0, end = 0; first < heights.size(); ++first) {
      while (end < heights.size() && heights[end] - heights[first] <= kSameFloor_m) ++end;
      if (end - first <= most) continue;
      most = end - first;
      best = first + most / 2;
    }
    return heights[best];
  }

 private:
  static constexpr double kBucket_m = 0.25;
  using Cell = std::pair<int, int>;
  static Cell cell_of(const Vector2d& place) {
    return {static_cast<int>(std::floor(place.x() / kBucket_m)),
            static_cast<int>(std::floor(place.y() / kBucket_m))};
  }
  template <typename Visit>
  static void visit_cells(const Vector2d& middle, double radius_m, const Visit& visit) {
    const Cell low = cell_of(middle - Vector2d::Constant(radius_m));
    const Cell high = cell_of(middle + Vector2d::Constant(radius_m));
    for (int y = low.second; y <= high.second; ++y) {
      for (int x = low.first; x <= high.first; ++x) visit(Cell(x, y));
    }
  }

  std::map<Cell, std::vector<Eigen::Vector3f>> cells_;
};

struct GroundPlace {
  Vector3d camera = Vector3d::Zero();
  std::optional<double> ground_m;
  double length_m = 0;  // of the path that it stands for
};
using GroundPath = std::vector<GroundPlace>;

GroundPath ground_under(const CameraPath& path, const LevelSurface& surface) {
  GroundPath grounds;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double walked_m = i == 0 ? 0 : (path[i].head<2>() - path[i - 1].head<2>()).norm();
    grounds.push_back({path[i], surface.ground_m(path[i]), std::min(walked_m, kLongestGap_m)});
  }
  return grounds;
}

// The heights at which most was walked, the most first, each farther than a person's height from
// all before it.
std::vector<double> levels_of(const std::vector<GroundPath>& paths) {
  std::vector<std::pair<double, double>> walked;  // height, length
  for (const GroundPath& path : paths) {
    for (const GroundPlace& place : path) {
      if (place.ground_m) walked.emplace_back(*place.ground_m, place.length_m);
    }
  }
  std::ranges::sort(walked);
  std::vector<double> levels;
  for (;;) {
    double max_m = 0, level_m = 0, window_m = 0;
    for (std::size_t first = 0, end = 0; first < walked.size(); ++first) {
      while (end < walked.size() && walked[end].first - walked[first].first <= 2 * kSameFloor_m) {
        window_m += walked[end++].second;
      }
      const double middle_m = walked[first + (end - first) / 2].first;
      const bool is_new = std::ranges::all_of(
          levels, [&](double level) { return std::abs(level - middle_m) >= kPerson_m; });
      if (is_new && window_m > max_m) {
        max_m = window_m;
        level_m = middle_m;
      }
      window_m -= walked[first].second;
    }
    if (max_m < kMinWalked_m) break;
    levels.push_back(level_m);
  }
  std::ranges::sort(levels);
  return levels;
}

// ---- stairs ----

// Where a walk led from one level to the next: the last place on the one, all between, the first on
// the other; turned so that it climbs.
struct Climb {
  std::size_t lower = 0;
  std::vector<Vector2d> way;
};

std::optional<std::size_t> level_at(const GroundPlace& place, const std::vector<double>& levels) {
  if (!place.ground_m) return std::nullopt;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (std::abs(*place.ground_m - levels[i]) <= kSameFloor_m) return i;
  }
  return std::nullopt;
}

bool is_unbroken(const GroundPath& path, std::size_t first, std::size_t last) {
  for (std::size_t i = first + 1; i <= last; ++i) {
    if ((path[i].camera - path[i - 1].camera).norm() > kLongestGap_m) return false;
  }
  return true;
}

std::vector<Climb> climbs_of(const GroundPath& path, const std::vector<double>& levels) {
  std::vector<Climb> climbs;
  std::optional<std::size_t> last;  // index of the last place on a level
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto level = level_at(path[i], levels);
    if (!level) continue;
    const auto before = last ? level_at(path[*last], levels) : std::nullopt;
    const bool is_next =
        before && std::max(*before, *level) - std::min(*before, *level) == 1 && i > *last + 1;
    if (is_next && is_unbroken(path, *last, i)) {
      Climb climb{std::min(*before, *level), {}};
      for (std::size_t k = *last; k <= i; ++k) climb.way.push_back(path[k].camera.head<2>());
      if (*level < *before) std::ranges::reverse(climb.way);
      climbs.push_back(std::move(climb));
    }
    last = i;
  }
  return climbs;
}

// A way as a line with a measure along it; straight where the walk was.
class Polyline {
 public:
  explicit Polyline(std::vector<Vector2d> way) {
    double length_m = 0;
    for (std::size_t i = 1; i < way.size(); ++i) length_m += (way[i] - way[i - 1]).norm();
    // Who sways by a hand's breadth over a few strides still walks straight on.
    constexpr double kStraight = 0.93;
    const bool is_straight = (way.back() - way.front()).norm() > kStraight * length_m;
    if (is_straight) way = {way.front(), way.back()};
    for (const Vector2d& place : way) {
      if (!points_.empty() && (place - points_.back()).norm() < 0.05) continue;
      along_m_.push_back(points_.empty() ? 0 : along_m_.back() + (place - points_.back()).norm());
      points_.push_back(place);
    }
  }

  [[nodiscard]] bool is_line() const { return points_.size() >= 2; }
  // Along and beside it, positive to the left; the first and last piece go on beyond the ends.
  [[nodiscard]] Vector2d measure(const Vector2d& place) const {
    Vector2d best(0, std::numeric_limits<double>::infinity());
    for (std::size_t i = 1; i < points_.size(); ++i) {
      const Vector2d direction = (points_[i] - points_[i - 1]).normalized();
      const Vector2d offset = place - points_[i - 1];
      const double length_m = along_m_[i] - along_m_[i - 1];
      const double low = i == 1 ? -1e9 : 0, high = i + 1 == points_.size() ? 1e9 : length_m;
      const double along = std::clamp(offset.dot(direction), low, high);
      const double apart_m = (offset - along * direction).norm();
      if (apart_m >= std::abs(best.y())) continue;
      const double left = direction.x() * offset.y() - direction.y() * offset.x();
      best = {along_m_[i - 1] + along, left < 0 ? -apart_m : apart_m};
    }
    return best;
  }
  [[nodiscard]] Vector2d at(double along_m) const {
    std::size_t i = 1;
    while (i + 1 < points_.size() && along_m > along_m_[i]) ++i;
    return points_[i - 1] +
           (along_m - along_m_[i - 1]) * (points_[i] - points_[i - 1]).normalized();
  }
  [[nodiscard]] double heading_rad(double along_m) const {
    const Vector2d direction = at(along_m + 0.01) - at(along_m - 0.01);
    return std::atan2(direction.y(), direction.x());
  }
  [[nodiscard]] double length_m() const { return along_m_.back(); }

 private:
  std::vector<Vector2d> points_;
  std::vector<double> along_m_;
};

// A place of the surface near a flight: along its axis, beside it, over the lower level.
struct FlightPlace {
  double along_m, beside_m, height_m;
};

// The number of steps into which the heights of the treads fall, and how well they do: 1 where all
// are whole steps, 0 where they are anything, as on a ramp.
std::pair<int, double> count_steps(const std::vector<FlightPlace>& treads, double height_m) {
  std::pair<int, double> best{0, 0};
  const int fewest = std::max(2, static_cast<int>(std::ceil(height_m / kMaxRise_m)));
  for (int steps = fewest; steps <= height_m / kMinRise_m; ++steps) {
    double sum = 0;
    for (const FlightPlace& place : treads) {
      sum += std::cos(2 * std::numbers::pi * steps * place.height_m / height_m);
    }
    const double score = treads.empty() ? 0 : sum / static_cast<double>(treads.size());
    if (score > best.second) best = {steps, score};
  }
  return best;
}

// What is measured on a flight whose steps are counted.
class Flight {
 public:
  Flight(const std::vector<FlightPlace>& places, double height_m, int steps)
      : places_(places), rise_m_(height_m / steps), steps_(steps) {
    fit_steps();
  }

  [[nodiscard]] bool is_fitted() const { return going_m_ > 0; }
  [[nodiscard]] double foot_m() const { return foot_m_; }
  [[nodiscard]] double top_m() const { return foot_m_ + (steps_ - 1) * going_m_; }

  // From right to left of the axis; nothing where treads were hardly seen.
  [[nodiscard]] std::optional<std::pair<double, double>> sides() const {
    std::map<int, std::set<int>> seen;  // by cell beside the axis: the steps
    for (const FlightPlace& place : places_) {
      const int step = tread_of(place);
      if (step > 0) seen[static_cast<int>(std::floor(place.beside_m / kCell_m))].insert(step);
    }
    const auto is_wide = [&](int cell) {
      const auto found = seen.find(cell);
      return found != seen.end() && 2 * static_cast<int>(found->second.size()) >= steps_ - 1;
    };
    int low = 0, high = 0;
    while (is_wide(low - 1)) --low;
    while (is_wide(high)) ++high;
    if (low == high) return std::nullopt;
    return std::pair(low * kCell_m, high * kCell_m);
  }

  // Beside an edge a rail stands where hands reach for it along most steps, and nothing above.
  [[nodiscard]] bool has_rail(double edge_m) const {
    constexpr double kBeside_m = 0.2;
    std::set<int> at_hand, above;
    for (const FlightPlace& place : places_) {
      if (std::abs(place.beside_m - edge_m) > kBeside_m) continue;
      const double steps = (place.along_m - foot_m_) / going_m_;
      const int step = static_cast<int>(std::floor(steps)) + 1;
      if (step < 1 || step >= steps_) continue;
      const double over_m = place.height_m - (steps + 1) * rise_m_;  // over the nosings
      if (over_m > 0.7 && over_m < 1.1) at_hand.insert(step);
      if (over_m > 1.3 && over_m < 1.8) above.insert(step);
    }
    const auto most = [&](const std::set<int>& found) {
      return 2 * static_cast<int>(found.size()) >= steps_ - 1;
    };
    return most(at_hand) && !most(above);
  }

 private:
  // Of a place on the axis' treads, from 1; 0: on none.
  [[nodiscard]] int tread_of(const FlightPlace& place) const {
    const double steps = place.height_m / rise_m_;
    const int step = static_cast<int>(std::lround(steps));
    if (std::abs(steps - step) > 0.25 || step < 1 || step >= steps_) return 0;
    if (!is_fitted()) return step;
    const double middle_m = foot_m_ + (step - 0.5) * going_m_;
    return std::abs(place.along_m - middle_m) < 0.75 * going_m_ ? step : 0;
  }

  // Treads lie at equal distances along the axis: a line through their middles.
  void fit_steps() {
    std::map<int, std::pair<double, int>> middles;
    for (const FlightPlace& place : places_) {
      if (std::abs(place.beside_m) > kBody_m) continue;
      const int step = tread_of(place);
      if (step == 0) continue;
      middles[step].first += place.along_m;
      ++middles[step].second;
    }
    if (middles.size() < 3) return;
    double n = 0, sum_k = 0, sum_s = 0, sum_kk = 0, sum_ks = 0;
    for (const auto& [step, sum] : middles) {
      const double k = step - 0.5, s = sum.first / sum.second;
      n += 1;
      sum_k += k;
      sum_s += s;
      sum_kk += k * k;
      sum_ks += k * s;
    }
    going_m_ = (n * sum_ks - sum_k * sum_s) / (n * sum_kk - sum_k * sum_k);
    foot_m_ = (sum_s - going_m_ * sum_k) / n;
  }

  const std::vector<FlightPlace>& places_;
  double rise_m_;
  int steps_;
  double going_m_ = 0, foot_m_ = 0;
};

// The surface about a flight.
struct FlightSurface {
  Polyline axis;
  std::size_t lower = 0;
  double from_m = 0, height_m = 0;  // of the level below, and up to the next
  std::vector<FlightPlace> places, treads;

  FlightSurface(const Climb& climb, const std::vector<double>& levels)
      : axis(climb.way),
        lower(climb.lower),
        from_m(levels[climb.lower]),
        height_m(levels[climb.lower + 1] - from_m) {}

  void add(const MeshPiece& piece) {
    constexpr double kBeside_m = 2.0;  // flights of homes are narrower
    for (std::size_t i = 0; i < piece.own; ++i) {
      const Vector3d place = piece.mesh.vertices[i].cast<double>();
      const double over_m = place.z() - from_m;
      if (over_m < kSameFloor_m || over_m > height_m + kPerson_m) continue;
      const Vector2d measured = axis.measure(place.head<2>());
      if (measured.x() < 0 || measured.x() > axis.length_m()) continue;
      if (std::abs(measured.y()) > kBeside_m) continue;
      const bool is_level = piece.mesh.normals[i].z() > 0.95F;
      const bool is_tread = is_level && over_m < height_m - kSameFloor_m;
      // A tread is level and below the upper floor; a rail or a wall is higher than 0.7 m.
      if (is_tread && std::abs(measured.y()) < kBody_m)
        treads.push_back({measured.x(), measured.y(), over_m});
      if (is_tread || over_m > 0.7) places.push_back({measured.x(), measured.y(), over_m});
    }
  }
};

Staircase staircase_on(const FlightSurface& surface) {
  const auto& [axis, lower, from_m, height_m, places, treads] = surface;
  Staircase stairs;
  stairs.lower = lower;
  double foot_m = std::min(kStand_m, axis.length_m() / 2);
  double top_m = axis.length_m() - foot_m;
  const auto [steps, score] = count_steps(treads, height_m);
  // Halfway between a ramp's treads, which are anywhere, and whole steps.
  constexpr double kMinScore = 0.5;
  if (steps > 0 && score >= kMinScore) {
    const Flight flight(places, height_m, steps);
    stairs.steps = steps;
    if (flight.is_fitted()) {
      foot_m = std::clamp(flight.foot_m(), 0.0, axis.length_m());
      top_m = std::clamp(flight.top_m(), foot_m, axis.length_m());
      if (const auto sides = flight.sides()) {
        stairs.width_m = sides->second - sides->first;
        stairs.has_right_rail = flight.has_rail(sides->first);
        stairs.has_left_rail = flight.has_rail(sides->second);
      }
    }
  }
  stairs.run_m = top_m - foot_m;
  stairs.height_m = height_m;
  stairs.foot_gravity = axis.at(foot_m);
  stairs.top_gravity = axis.at(top_m);
  stairs.up_rad = axis.heading_rad(foot_m);
  stairs.end_rad = axis.heading_rad(top_m);
  stairs.below_plan = axis.at(foot_m - kStand_m);  // still in the gravity-aligned frame
  stairs.above_plan = axis.at(top_m + kStand_m);
  return stairs;
}

// The same flight is walked more than once: the first walk on which its steps could be counted
// tells.
void keep_best(Staircase stairs, std::vector<Staircase>& all) {
  constexpr double kSame_m = 1.0;
  const auto known = std::ranges::find_if(all, [&](const Staircase& one) {
    return one.lower == stairs.lower && (one.foot_gravity - stairs.foot_gravity).norm() < kSame_m &&
           (one.top_gravity - stairs.top_gravity).norm() < kSame_m;
  });
  if (known == all.end()) {
    all.push_back(std::move(stairs));
    return;
  }
  const bool has_left_rail = known->has_left_rail || stairs.has_left_rail;
  const bool has_right_rail = known->has_right_rail || stairs.has_right_rail;
  if ((stairs.steps > 0) > (known->steps > 0)) *known = std::move(stairs);
  known->has_left_rail = has_left_rail;
  known->has_right_rail = has_right_rail;
}

}  // namespace

std::size_t Storeys::at_height(double z_m) const {
  std::size_t storey = 0;
  for (std::size_t i = 1; i < storeys_.size(); ++i) {
    if (z_m >= storeys_[i].floor_m - kSag_m) storey = i;
  }
  return storey;
}

std::size_t Storeys::at_plan(const Vector2d& point_plan) const {
  std::size_t storey = 0;
  for (std::size_t i = 1; i < storeys_.size(); ++i) {
    if (point_plan.x() >= storeys_[i].plan_from_x_m) storey = i;
  }
  return storey;
}

Vector3d Storeys::plan_from_gravity(const Vector3d& point_gravity) const {
  if (storeys_.empty()) return point_gravity;
  const Storey& storey = storeys_[at_height(point_gravity.z())];
  return point_gravity +
         Vector3d(storey.plan_from_gravity.x(), storey.plan_from_gravity.y(), -storey.floor_m);
}

Vector3d Storeys::gravity_from_plan(const Vector3d& point_plan) const {
  if (storeys_.empty()) return point_plan;
  const Storey& storey = storeys_[at_plan(point_plan.head<2>())];
  return point_plan -
         Vector3d(storey.plan_from_gravity.x(), storey.plan_from_gravity.y(), -storey.floor_m);
}

const Staircase* Storeys::stairs_at(const Vector2d& point_plan) const {
  constexpr double kAside_m = 1.0;  // where the width was not seen
  if (storeys_.empty()) return nullptr;
  const std::size_t here = at_plan(point_plan);
  const Vector2d place = point_plan - storeys_[here].plan_from_gravity;
  for (const Staircase& stairs : stairs_) {
    if (here != stairs.lower && here != stairs.lower + 1) continue;
    const Vector2d up = stairs.top_gravity - stairs.foot_gravity;
    const Vector2d offset = place - stairs.foot_gravity;
    const double along = up.squaredNorm() > 0 ? offset.dot(up) / up.squaredNorm() : 0;
    if (along <= 0 || along >= 1) continue;
    const double half_m = (stairs.width_m > 0 ? stairs.width_m : kAside_m) / 2;
    if ((offset - along * up).norm() <= half_m) return &stairs;
  }
  return nullptr;
}

double Storeys::beyond_m(const Staircase& stairs, bool is_up, const Vector2d& point_plan) const {
  const Vector2d place = point_plan - storeys_[at_plan(point_plan)].plan_from_gravity;
  const double heading = is_up ? stairs.end_rad : stairs.up_rad;
  const Vector2d climbing(std::cos(heading), std::sin(heading));
  return is_up ? (place - stairs.top_gravity).dot(climbing)
               : (stairs.foot_gravity - place).dot(climbing);
}

Expected<StoreysFound> find_storeys(const PiecewiseMesh& mesh_gravity,
                                    std::span<const CameraPath> paths) {
  std::vector<GroundPath> grounds;
  {
    LevelSurface surface(paths);
    ROOMWISE_RETURN_IF_ERROR(
        mesh_gravity.for_each([&](const MeshPiece& piece) { surface.add(piece); }));
    for (const CameraPath& path : paths) grounds.push_back(ground_under(path, surface));
  }
  StoreysFound found;
  found.floors_m = levels_of(grounds);
  if (found.floors_m.size() < 2) return found;
  std::vector<FlightSurface> flights;
  for (const GroundPath& path : grounds) {
    for (const Climb& climb : climbs_of(path, found.floors_m)) {
      flights.emplace_back(climb, found.floors_m);
      if (!flights.back().axis.is_line()) flights.pop_back();
    }
  }
  ROOMWISE_RETURN_IF_ERROR(mesh_gravity.for_each([&](const MeshPiece& piece) {
    for (FlightSurface& flight : flights) flight.add(piece);
  }));
  for (const FlightSurface& flight : flights) keep_best(staircase_on(flight), found.stairs);
  return found;
}

double only_level_m(const StoreysFound& found) {
  if (found.floors_m.size() != 1) return 0;
  constexpr double kHalfStorey_m = 1.2;  // higher than tables and counters
  const double floor_m = found.floors_m.front();
  return std::abs(floor_m) > kHalfStorey_m ? floor_m : 0;
}

}  // namespace roomwise::fusion
