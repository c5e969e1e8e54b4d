#include "roomwise/rooms/layout/named_walks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace roomwise::rooms {
namespace {

// Between two places farther apart than that, the walk may have led through another room.
constexpr double kLongestGap_m = 2.0;

std::vector<std::string> room_names(std::span<const WalkedPath> walks) {
  std::set<std::string> names;
  for (const WalkedPath& walk : walks) {
    for (const WalkedPlace& place : walk) {
      if (!place.room.empty()) names.insert(place.room);
    }
  }
  return {names.begin(), names.end()};
}

std::vector<double> lengths_along(const WalkedPath& walk) {
  std::vector<double> along_m;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    along_m.push_back(
        i == 0 ? 0 : along_m.back() + (walk[i].point_plan - walk[i - 1].point_plan).norm());
  }
  return along_m;
}

// Takes the nameless places of a walk. Where along the path their stretches begin and end beside a
// name.
std::vector<double> read_nameless(const WalkedPath& walk, double unsure_path_m, NamedWalks& read) {
  const std::vector<double> along_m = lengths_along(walk);
  std::vector<double> ends_m;
  for (std::size_t first = 0, end = 0; first < walk.size(); first = end + 1) {
    for (end = first; end < walk.size() && walk[end].room.empty();) ++end;
    bool has_deep_places = false;
    for (std::size_t i = first; i < end; ++i) {
      const double from_end_m =
          std::min(along_m[i] - along_m[first], along_m[end - 1] - along_m[i]);
      if (!(from_end_m > unsure_path_m)) continue;
      read.nameless.push_back(walk[i].point_plan);
      has_deep_places = true;
    }
    if (has_deep_places && first > 0) ends_m.push_back(along_m[first]);
    if (has_deep_places && end < walk.size()) ends_m.push_back(along_m[end - 1]);
  }
  return ends_m;
}

void read_walk(const WalkedPath& walk, double unsure_path_m, NamedWalks& read) {
  std::vector<WalkEvidence> named;
  std::vector<double> along_m;  // along the path, as the crossings are
  std::vector<double> crossings_m = read_nameless(walk, unsure_path_m, read);
  double length_m = 0;
  const WalkedPlace* before = nullptr;
  bool is_unbroken = true;  // since the last named place
  for (const WalkedPlace& place : walk) {
    if (before != nullptr) length_m += (place.point_plan - before->point_plan).norm();
    before = &place;
    if (place.room.empty()) {
      is_unbroken = false;
      continue;
    }
    const auto room = static_cast<std::int16_t>(std::ranges::lower_bound(read.names, place.room) -
                                                read.names.begin());
    if (!named.empty() && named.back().room != room) {
      // Where the walk was lost or unnamed in between, there may be other rooms.
      const double gap_m = (place.point_plan - named.back().place).norm();
      if (is_unbroken && gap_m <= kLongestGap_m) {
        read.crossings.push_back(
            {named.back().room, room, (named.back().place + place.point_plan) / 2});
      }
      crossings_m.push_back((along_m.back() + length_m) / 2);
    }
    named.push_back({room, place.point_plan, std::numeric_limits<double>::infinity()});
    is_unbroken = true;
    along_m.push_back(length_m);
  }
  for (std::size_t i = 0; i < named.size(); ++i) {
    for (const double crossing_m : crossings_m) {
      named[i].from_crossing_m =
          std::min(named[i].from_crossing_m, std::abs(along_m[i] - crossing_m));
    }
  }
  read.evidence.insert(read.evidence.end(), named.begin(), named.end());
}

}  // namespace

NamedWalks read_walks(std::span<const WalkedPath> walks, double unsure_path_m) {
  NamedWalks read{room_names(walks), {}, {}, {}};
  for (const WalkedPath& walk : walks) read_walk(walk, unsure_path_m, read);
  return read;
}

std::vector<WalkEvidence> believed(const NamedWalks& walks, double unsure_path_m) {
  std::vector<double> farthest_m(walks.names.size(), 0);
  for (const WalkEvidence& one : walks.evidence) {
    double& farthest = farthest_m[static_cast<std::size_t>(one.room)];
    farthest = std::max(farthest, std::min(one.from_crossing_m, unsure_path_m));
  }
  std::vector<WalkEvidence> kept;
  std::ranges::copy_if(walks.evidence, std::back_inserter(kept), [&](const WalkEvidence& one) {
    return one.from_crossing_m >= farthest_m[static_cast<std::size_t>(one.room)];
  });
  return kept;
}

}  // namespace roomwise::rooms
