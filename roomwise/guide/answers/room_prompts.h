#pragma once

#include <optional>
#include <string>

#include "roomwise/guide/words/wording.h"
#include "roomwise/rooms/recognition/room_decision.h"

namespace roomwise::guide {

// Where there is more to see, for somebody whose pictures do not tell the room.
enum class TurnHint { kAnywhere, kLeft, kRight };

// The answer to "where am I": "You are in the kitchen.", "Probably the kitchen.", "Either
// the kitchen or the hall.", "I am not sure.
// Turn slowly to the left.", "I do not know this place."
[[nodiscard]] Prompt room_prompt(const rooms::RoomDecision& decision, TurnHint hint,
                                 const Wording& wording, TimestampNs now_ns);
// What is called out when a room is entered: "Now in the kitchen." Nothing where no room is sure:
// nobody asked.
[[nodiscard]] std::optional<Prompt> entered_prompt(const rooms::RoomDecision& decision,
                                                   const Wording& wording, TimestampNs now_ns);
// Somebody has named the room that they stand in: "Thank you. This is the kitchen."
[[nodiscard]] Prompt named_prompt(const std::string& room, const Wording& wording,
                                  TimestampNs now_ns);

}  // namespace roomwise::guide
