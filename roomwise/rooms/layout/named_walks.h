#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace roomwise::rooms {

// Where the walker stood, on the plan (fusion/storeys.h; m), and in which room that was; no name:
// not known.
struct WalkedPlace {
  Eigen::Vector2d point_plan = Eigen::Vector2d::Zero();
  std::string room;
  std::string room_before_edits = {};  // where a line or an outline (LayoutEdit) made it another's
};
using WalkedPath = std::vector<WalkedPlace>;  // in the order of time

// Where a walk goes from one named room into another. Rooms are indices into NamedWalks::names.
struct Crossing {
  std::int16_t from = 0, to = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
};

// A named place, and how far along the path the nearest change of name is, to a stretch with
// nameless places too.
struct WalkEvidence {
  std::int16_t room = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double from_crossing_m = std::numeric_limits<double>::infinity();
};

// What walks say about rooms.
struct NamedWalks {
  std::vector<std::string> names;      // of the rooms, sorted
  std::vector<WalkEvidence> evidence;  // of every named place
  // Places deep in a stretch that has no name: farther along it than unsure_path_m from both its
  // ends. They are in some room that nobody named. In a shorter stretch a name came late.
  std::vector<Eigen::Vector2d> nameless;
  // Not where a walk was lost or unnamed for more than a few steps: there may be other rooms
  // between.
  std::vector<Crossing> crossings;
};
[[nodiscard]] NamedWalks read_walks(std::span<const WalkedPath> walks, double unsure_path_m);

// The places that say for certain whose floor they are on: those so far from a change of name, or a
// room's farthest where none is.
[[nodiscard]] std::vector<WalkEvidence> believed(const NamedWalks& walks, double unsure_path_m);

}  // namespace roomwise::rooms
