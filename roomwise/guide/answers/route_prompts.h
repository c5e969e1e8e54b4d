#pragma once

#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/places/places.h"
#include "roomwise/guide/way/route.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// A way in words: "Turn right, then 4 steps to the door.", "Straight on, then 3 steps to the
// microwave." A leg a prompt, four at most, from how somebody stands; doors end a leg, stairs are
// one. Who is led along takes the first one and asks again on the way. `confidence`: kProbable
// where the goal may not be there. Never empty: "You are at the microwave."
[[nodiscard]] std::vector<Prompt> route_prompts(const Route& route, const Pose& pose,
                                                const Noun& goal,
                                                std::span<const rooms::Doorway> doorways,
                                                const Wording& wording, TimestampNs now_ns,
                                                std::span<const fusion::Staircase> stairs = {},
                                                Confidence confidence = Confidence::kSure);
// That there is no such thing in a room, where another room has one.
[[nodiscard]] Prompt none_in_room_prompt(const Noun& thing, const std::string& room,
                                         const Wording& wording, TimestampNs now_ns);
// Where find_route() fails, or nobody knows where the person stands.
[[nodiscard]] Prompt no_route_prompt(bool has_pose, std::string because, const Wording& wording,
                                     TimestampNs now_ns);

}  // namespace roomwise::guide
