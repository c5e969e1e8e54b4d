#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/stored/stored_rooms.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::pipeline {

// A thing of the home as it is told to other programs.
struct ThingContent {
  objects::Instance instance;
  std::uint64_t component = 0;
  // In the gravity-aligned frame; absent for a thing of another component than the largest, which
  // has a world of its own.
  std::optional<geometry::OrientedBox> box_gravity;
  std::optional<std::string> room;
  std::optional<Sighting> first_seen, last_seen;  // absent where no walk is known to have seen it
  std::string visit;                              // that brought it; empty: none did
  std::string note;                               // that people wrote on it; may be empty
  bool is_confirmed = false;                      // people who were there say so
};

struct WalkContent {
  home::StoredRecording stored;
  std::vector<home::Keyframe> keyframes;  // by id, of all components
  std::uint64_t frames = 0;
  std::uint64_t placed = 0;  // of these, those on the largest component
};

// What a home holds that other programs ask for, read once.
struct HomeContents {
  HomeFloor floor;
  std::optional<rooms::RoomLayout> layout;  // where the map shows where the rooms lie
  std::vector<rooms::Room> rooms;           // as they were named, by name
  std::vector<ThingContent> things;         // in the order of the home's instances
  std::vector<WalkContent> walks;           // as they were added
  KeyframeRooms keyframe_rooms;

  [[nodiscard]] const geometry::RigidTransform& gravity_from_world() const {
    return floor.frame.gravity_from_world;
  }
  [[nodiscard]] const fusion::Storeys& storeys() const { return floor.frame.storeys; }
  // A place of the layout in the gravity-aligned frame, on the floor of its storey.
  [[nodiscard]] Eigen::Vector3d place_gravity(const Eigen::Vector2d& point_plan) const {
    return storeys().gravity_from_plan({point_plan.x(), point_plan.y(), 0});
  }
  // Parts of the map that no loop joined to its largest: key-frames and things in them.
  [[nodiscard]] std::size_t keyframes_apart() const;
  [[nodiscard]] std::size_t things_apart() const;
};

// Fails where the home has no map; where its floor is not kept and its pictures are protected by a
// passphrase that was not given; and when the user interrupts.
[[nodiscard]] Expected<HomeContents> read_home_contents(const home::Home& home, RunContext& run);

}  // namespace roomwise::pipeline
