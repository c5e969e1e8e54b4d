#include "roomwise/rooms/recognition/two_frame_rule.h"

#include <algorithm>

namespace roomwise::rooms {
namespace {

// The home's only room of a type; nothing where it has none or several.
std::optional<std::string> only_room_of(std::string_view type, std::span<const Room> rooms) {
  const auto is_of_type = [&](const Room& room) { return room.type == type; };
  if (std::ranges::count_if(rooms, is_of_type) != 1) return std::nullopt;
  return std::ranges::find_if(rooms, is_of_type)->name;
}

}  // namespace

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::kSingleFrame:
      return "single frame";
    case Reason::kFramesAgree:
      return "frames agree";
    case Reason::kRepresentativeObject:
      return "representative object";
    case Reason::kHigherScore:
      return "higher score";
  }
  return "unknown";
}

RoomAnswer decide(const RoomScore& first, const RoomScore& second,
                  const std::function<std::vector<objects::ObjectScore>()>& objects_of_second,
                  const Concepts& concepts, std::span<const Room> rooms) {
  const RoomScore& surer = first.score > second.score ? first : second;
  if (first.room == second.room) return {surer.room, surer.score, Reason::kFramesAgree, ""};
  for (const objects::ObjectScore& observation : objects_of_second()) {
    const auto type = concepts.represented_room_type(observation.object);
    if (!type) continue;
    if (const auto room = only_room_of(*type, rooms)) {
      return {*room, observation.score, Reason::kRepresentativeObject, observation.object};
    }
  }
  return {surer.room, surer.score, Reason::kHigherScore, ""};
}

}  // namespace roomwise::rooms
