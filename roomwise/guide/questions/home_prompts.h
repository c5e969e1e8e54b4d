#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/way/plan.h"
#include "roomwise/guide/words/wording.h"

// Answers from what the map knows. Each is never empty; what holds of the map only, and not of this
// moment, is said as what is known. Where things are named, the day of the one that was not seen
// for longest follows, if it and `today` are known.
namespace roomwise::guide {

struct Today {
  TimestampNs now_ns = 0;
  std::optional<CalendarTime> date = std::nullopt;
};

// "what is on the table": what does not stand on the floor, and whose middle lies over the box of
// the nearest thing of this name, no more than a hand's breadth above it.
[[nodiscard]] std::vector<Prompt> on_prompts(const std::string& surface, const HomeMap& map,
                                             const UserLocation& location, const Wording& wording,
                                             const Today& today);
// "what is in the kitchen".
[[nodiscard]] std::vector<Prompt> in_prompts(const std::string& room, const HomeMap& map,
                                             const Wording& wording, const Today& today);
// "which rooms are there".
[[nodiscard]] std::vector<Prompt> rooms_prompts(const std::vector<std::string>& rooms,
                                                const Wording& wording, const Today& today);
// "where is the kitchen": here, the rooms on the way there, or its direction.
[[nodiscard]] std::vector<Prompt> room_way_prompts(const std::string& room, const HomeMap& map,
                                                   const UserLocation& location,
                                                   const Wording& wording, const Today& today);
// "which way do I face": the nearest thing or door at 12 o'clock.
[[nodiscard]] std::vector<Prompt> facing_prompts(const HomeMap& map, const UserLocation& location,
                                                 const Wording& wording, const Today& today);
// What a camera's depth shows of the way, now.
struct DepthAhead {
  bool is_measured = false;                         // there is depth
  std::optional<double> obstacle_m = std::nullopt;  // absent: it shows none within a step
};
// "what is ahead": what depth shows, then what the map's floor has within six metres, in the
// breadth of a person. What the map does not know, also beside the line, ends what it tells of.
// Without depth nobody looks at the way, and what the map has is said as the map's and probable.
[[nodiscard]] std::vector<Prompt> ahead_prompts(const HomeMap& map, const UserLocation& location,
                                                const DepthAhead& depth, const Wording& wording,
                                                const Today& today);
// "describe the room": its free floor, where it leads, and its things clockwise about its middle,
// from the door on that is nearest to the person.
[[nodiscard]] std::vector<Prompt> describe_prompts(const std::string& room, const HomeMap& map,
                                                   const UserLocation& location,
                                                   const Wording& wording, const Today& today);
// What the newest look at the home found otherwise than it was known.
struct ChangedThings {
  std::vector<KnownThing> arrived;
  std::vector<KnownThing> moved;    // as they stand now
  std::vector<KnownThing> shifted;  // pushed or turned, and not found again: about where they were
  std::vector<KnownThing> gone;     // as they stood; seen when last they were

  [[nodiscard]] bool empty() const {
    return arrived.empty() && moved.empty() && shifted.empty() && gone.empty();
  }
};
// "what changed": by what happened and by room, and of what has no known room, that it is so.
[[nodiscard]] std::vector<Prompt> change_prompts(const ChangedThings& changed,
                                                 const Wording& wording, const Today& today);

}  // namespace roomwise::guide
