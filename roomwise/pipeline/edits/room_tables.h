#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "roomwise/home/home.h"

// The home's own tables of rooms as a change finds and leaves them. For source files only.
namespace roomwise::pipeline {

struct RoomTables {
  nlohmann::json rooms;   // [{"name", "type"}], by name
  nlohmann::json claims;  // what was said of objects and rooms, as the home keeps it
  std::map<home::RecordingId, std::vector<recording::RoomRange>> ranges;
};
[[nodiscard]] Expected<RoomTables> read_room_tables(const home::Home& home);

// What a change changed of them, as home::Edit::before.
[[nodiscard]] std::string changed_tables(const RoomTables& before, const RoomTables& after);
// Puts back what stood there before. Fails where frames that were named since belong to a room that
// would go.
[[nodiscard]] Expected<void> restore_tables(home::Home& home, const std::string& changed);

// Changes which frames of each walk are in which room. A walk whose ranges stay is not written.
using RoomRanges = std::vector<recording::RoomRange>;
[[nodiscard]] Expected<void> change_room_ranges(
    home::Home& home,
    const std::function<Expected<void>(home::RecordingId walk, RoomRanges& ranges)>& change);

// A room's name wherever the home has it: list, ranges, claims, what was learned, and where
// people's own things were seen.
[[nodiscard]] Expected<void> change_room_name(home::Home& home, const std::string& name,
                                              const std::string& new_name);
// The name of the room in which people's own things were seen last.
[[nodiscard]] Expected<void> rename_where_seen(home::Home& home, const std::string& name,
                                               const std::string& new_name);
}  // namespace roomwise::pipeline
