#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/changes/changes.h"
#include "roomwise/objects/changes/surface_changes.h"
#include "roomwise/pipeline/visits/visit_frames.h"

namespace roomwise::pipeline {

struct UpdateOptions {
  VisitOptions visit;
  // Of the visit's things: it sees each less often than the walk that made the map.
  objects::InstanceOptions instances{.min_observations = 2};
  objects::ChangeOptions changes;
  objects::SurfaceChangeOptions surfaces;

  [[nodiscard]] Expected<void> validate() const;
};

// A thing of the home or of a visit and what the visit says of it.
struct ThingUpdate {
  objects::ChangeState state = objects::ChangeState::kThere;  // of one that the home knew
  bool is_new = false;                                        // one that it did not
  std::string name;
  double probability = 0;
  // See objects::InstanceChange: of one that the home knew, by the visit's depth; of where it or
  // one that is new stands now, by the map's.
  objects::FreeSpaceEvidence evidence, evidence_now;
  // In the map's world: where it was, where it is now. One that is new has no place before, one
  // that is gone none now; one that was shifted, or was not looked at, is taken to stand where it
  // stood.
  std::optional<geometry::OrientedBox> before, now;
  std::string room_before, room_now;  // as the helper named it near there; empty: not known

  // New, gone or not as it stood.
  [[nodiscard]] bool is_changed() const {
    return is_new ||
           (state != objects::ChangeState::kThere && state != objects::ChangeState::kUnobserved);
  }
};

// Something that depth shows to be new, or gone, and that is none of the things that changed, by
// this visit or an earlier one: nothing has a name for it. The home does not keep it.
struct UnnamedChange {
  bool is_new = false;                  // otherwise it is gone
  geometry::OrientedBox box_world;      // where it stands, or stood; upright
  std::string room;                     // as of ThingUpdate
  std::string beside;                   // the thing that stands nearest, within 0.5 m; empty: none
  bool is_like_a_leaf = false;          // as tall, wide and thin as a door's leaf; no more is known
  objects::FreeSpaceEvidence evidence;  // of the other walk's depth
};

struct HomeUpdate {
  std::vector<ThingUpdate> things;     // those that the home knew, in its order, then the new ones
  std::vector<UnnamedChange> unnamed;  // the largest first
  std::optional<RoomUpdate> rooms;     // where they were to be refreshed
  OwnThingSightings own_things;        // where things that people taught were seen last
  home::HomeChanges changes;           // what Home::apply_changes() takes
};

// Compares a home's map with a later walk through the same home: frames are placed on the map and
// looked at (observe_visit), what is found in them is joined into things, and these and their depth
// are compared with the things of the home (objects::find_changes). By the frames that show
// their room surely the learned rooms are to be known, too (VisitRooms); where none were learned,
// the update says why. Reads only. Fails where the home has no map, where no finder has looked at
// it, where the network is not among `networks` that its rooms were learned with, and where fewer
// than two frames were placed.
[[nodiscard]] Expected<HomeUpdate> compare_with_visit(
    const home::Home& home, const VisitRecording& visit, const objects::ObjectFinders& finders,
    const Networks& networks, const UpdateOptions& options, RunContext& run);

}  // namespace roomwise::pipeline
