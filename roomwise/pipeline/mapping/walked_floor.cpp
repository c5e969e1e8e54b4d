#include "roomwise/pipeline/mapping/walked_floor.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace roomwise::pipeline {
namespace {

using Eigen::Vector2d;

constexpr double kHalfBody_m = 0.2;  // of who carried the camera, with the shoulders in
// Who moved less stands still, so frames of a minute are one station.
constexpr double kStill_m = 0.05;
// From one station to the next people go straight, if it is no more than so much.
constexpr double kStep_m = 1, kStep_s = 2;
// Whose camera rises or sinks by more may be on a step: those that people build begin at 0.12 m.
constexpr double kLevel_m = 0.1;
// A camera is held half a metre ahead of the feet, sinks within a third of one once they go down,
// and what it led over is as wide as a body: so far before steps may a level camera be over them.
constexpr double kAhead_m = 0.9;
constexpr double kTallest_m = 1.9;  // a camera is held under the top of a head

// Where the camera was.
struct Station {
  home::RecordingId recording = 0;
  TimestampNs from_ns = 0, to_ns = 0;
  Vector2d place = Vector2d::Zero();  // on the plan
  double height_m = 0;                // over the storey's floor
  std::size_t storey = 0;
  bool is_on_stairs = false;  // recognised ones
  bool is_level = false;      // as high as it is mostly held in this walk, and over no stairs
};

// How high each walk holds its camera on each storey: the median.
std::map<std::pair<home::RecordingId, std::size_t>, double> usual_heights_m(
    std::span<const Station> stations) {
  std::map<std::pair<home::RecordingId, std::size_t>, std::vector<double>> all;
  for (const Station& one : stations) all[{one.recording, one.storey}].push_back(one.height_m);
  std::map<std::pair<home::RecordingId, std::size_t>, double> usual;
  for (auto& [walk, heights] : all) {
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::ranges::nth_element(heights, middle);
    usual[walk] = *middle;
  }
  return usual;
}

bool stands_still(const Station& before, const WalkedFrame& now, const Eigen::Vector3d& place) {
  const Eigen::Vector3d there(before.place.x(), before.place.y(), before.height_m);
  return now.recording == before.recording && (place - there).norm() < kStill_m;
}

std::vector<Station> stations_of(std::span<const WalkedFrame> frames,
                                 const fusion::GravityAlignedFrame& frame) {
  std::vector<Station> stations;
  for (const WalkedFrame& one : frames) {
    const Eigen::Vector3d place = frame.on_plan(one.at_world);
    if (!stations.empty() && stands_still(stations.back(), one, place)) {
      stations.back().to_ns = one.timestamp_ns;
      continue;
    }
    stations.push_back({one.recording, one.timestamp_ns, one.timestamp_ns, place.head<2>(),
                        place.z(), frame.storeys.at_plan(place.head<2>())});
  }
  const auto usual = usual_heights_m(stations);
  for (Station& one : stations) {
    const double usual_m = usual.at({one.recording, one.storey});
    one.is_on_stairs = frame.storeys.stairs_at(one.place) != nullptr;
    one.is_level = !one.is_on_stairs && usual_m > 0 && usual_m <= kTallest_m &&
                   std::abs(one.height_m - usual_m) <= kLevel_m;
  }
  return stations;
}

bool is_near(const Station& from, const Station& to) {
  return from.recording == to.recording && from.storey == to.storey &&
         (to.place - from.place).norm() <= kStep_m &&
         std::abs(to.height_m - from.height_m) <= kLevel_m;
}

// Over one floor.
bool goes_on(const Station& from, const Station& to) {
  return from.is_level && to.is_level && is_near(from, to);
}

bool comes_to_stairs(const Station& floor, const Station& stairs) {
  return floor.is_level && stairs.is_on_stairs && is_near(floor, stairs);
}

// Whether the walk goes on level from a station until it is kAhead_m away: then the feet followed.
// Where recognised stairs begin is known, so it may come to them before.
bool is_level_after(std::span<const Station> stations, std::size_t at) {
  std::size_t i = at + 1;
  for (; i < stations.size() && goes_on(stations[i - 1], stations[i]); ++i) {
    if ((stations[i].place - stations[at].place).norm() >= kAhead_m) return true;
  }
  return i < stations.size() && comes_to_stairs(stations[i - 1], stations[i]);
}

// Likewise whether it came level to there, or began: where it begins the feet are behind.
bool is_level_before(std::span<const Station> stations, std::size_t at) {
  std::size_t i = at;
  for (; i > 0 && goes_on(stations[i - 1], stations[i]); --i) {
    if ((stations[i - 1].place - stations[at].place).norm() >= kAhead_m) return true;
  }
  return i == 0 || stations[i - 1].recording != stations[i].recording ||
         comes_to_stairs(stations[i], stations[i - 1]);
}

// Whether one walked over level floor to a station from the one before it.
bool is_step(std::span<const Station> stations, std::size_t to) {
  return goes_on(stations[to - 1], stations[to]) &&
         seconds_between(stations[to - 1].to_ns, stations[to].from_ns) <= kStep_s &&
         is_level_before(stations, to - 1) && is_level_after(stations, to);
}

double distance_m(const Vector2d& from, const Vector2d& to, const Vector2d& point) {
  const Vector2d way = to - from;
  const double along = way.squaredNorm() > 0 ? (point - from).dot(way) / way.squaredNorm() : 0;
  return (from + std::clamp(along, 0.0, 1.0) * way - point).norm();
}

void walk(const Vector2d& from, const Vector2d& to, const fusion::FloorGrid& floor,
          image::Image<fusion::FloorCell>& cells) {
  const Vector2d margin = Vector2d::Constant(kHalfBody_m);
  const Vector2d lowest = (from.cwiseMin(to) - margin - floor.origin_m()) / floor.cell_m();
  const Vector2d highest = (from.cwiseMax(to) + margin - floor.origin_m()) / floor.cell_m();
  const auto cell = [](double value, int count) {
    return static_cast<int>(std::clamp(std::floor(value), 0.0, static_cast<double>(count - 1)));
  };
  for (int row = cell(lowest.y(), floor.rows()); row <= cell(highest.y(), floor.rows()); ++row) {
    for (int column = cell(lowest.x(), floor.columns());
         column <= cell(highest.x(), floor.columns()); ++column) {
      const bool is_walked = distance_m(from, to, floor.cell_middle_m(column, row)) <= kHalfBody_m;
      fusion::FloorCell& state = cells.at(column, row);
      if (is_walked && state == fusion::FloorCell::kUnknown) state = fusion::FloorCell::kFree;
    }
  }
}

}  // namespace

fusion::FloorGrid with_walked_ways(const fusion::FloorGrid& floor,
                                   const fusion::GravityAlignedFrame& frame,
                                   std::span<const WalkedFrame> frames) {
  image::Image<fusion::FloorCell> cells(floor.columns(), floor.rows());
  for (int row = 0; row < floor.rows(); ++row) {
    for (int column = 0; column < floor.columns(); ++column)
      cells.at(column, row) = floor.at(column, row);
  }
  const std::vector<Station> stations = stations_of(frames, frame);
  for (std::size_t i = 1; i < stations.size(); ++i) {
    if (is_step(stations, i)) walk(stations[i - 1].place, stations[i].place, floor, cells);
  }
  return {floor.origin_m(), floor.cell_m(), std::move(cells)};
}

}  // namespace roomwise::pipeline
