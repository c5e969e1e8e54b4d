#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/places/places.h"
#include "roomwise/guide/words/wording.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

// The answer to "what is around me", in the order in which it is to be spoken: first what is in
// reach of a hand, by name; then a prompt a thing with its direction and distance, what is near and
// large before what is far and small. Four things at most, one of a name, and none of other rooms.
// Without a pose the names of what is in the room. What was seen long ago (`today` tells how long)
// is probable only. `is_on_map`: false of a room that is known by its photos alone, of which that
// there is nothing cannot be said. Never empty.
[[nodiscard]] std::vector<Prompt> around_prompts(const UserLocation& location,
                                                 std::span<const KnownThing> things,
                                                 const Wording& wording, TimestampNs now_ns,
                                                 const std::optional<CalendarTime>& today = {},
                                                 bool is_on_map = true);

// A side of who asks, three hours of the clock.
enum class Side { kLeft, kRight, kBehind };
// The answer to "what is on my left": as around_prompts(), of those of `things` (of this room and
// storey) whose middle, or the point of which that is nearest, lies on that side. Unsure where the
// place is not known. Never empty.
[[nodiscard]] std::vector<Prompt> side_prompts(Side side, const UserLocation& location,
                                               std::span<const KnownThing> things,
                                               const Wording& wording, TimestampNs now_ns,
                                               const std::optional<CalendarTime>& today = {});

// The answer to "where can I sit": as around_prompts(), of what people sit on (objects::Kind);
// where there is nothing in this room, the nearest elsewhere as in where_prompts(). Never empty.
[[nodiscard]] std::vector<Prompt> seat_prompts(const UserLocation& location,
                                               std::span<const KnownThing> things,
                                               std::span<const rooms::Doorway> doorways,
                                               const objects::ObjectVocabulary& vocabulary,
                                               const Wording& wording, TimestampNs now_ns,
                                               const std::optional<CalendarTime>& today = {});

// The thing of the home that somebody means by a name: the home's own name, what it is called in
// their language, or a label that the vocabulary knows for it; nothing where the home has none.
[[nodiscard]] std::optional<std::string> thing_meant(const std::string& asked,
                                                     std::span<const KnownThing> things,
                                                     const objects::ObjectVocabulary& vocabulary,
                                                     const Phrasebook& phrases);

// The answer to "where is X": the nearest of that name by direction and distance in the same room,
// else its room and the rooms on the way there; of a kind that people carry about (objects::Kind)
// when it was seen, if that and `today` are known; then how many there are, if several. Never
// empty.
[[nodiscard]] std::vector<Prompt> where_prompts(
    const std::string& asked, const UserLocation& location, std::span<const KnownThing> things,
    std::span<const rooms::Doorway> doorways, const objects::ObjectVocabulary& vocabulary,
    const Wording& wording, TimestampNs now_ns, const std::optional<CalendarTime>& today = {});

// The answer to who asks for a door of a room, or between two, where the map has none.
[[nodiscard]] Prompt no_door_prompt(const std::string& room, const std::string& other_room,
                                    const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
