#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/guide/led/followed_way.h"
#include "roomwise/guide/words/wording.h"

// What who is led hears of their way and of its end.
namespace roomwise::guide {

// By the door at which the leg ends, or else by the nearest thing: "The door is behind you."
[[nodiscard]] std::optional<Phrase> standing_phrase(const FollowedWay& way, const Pose& pose);
// What comes at the end of the leg, to which so much is left: "In 3 steps: through the door."
[[nodiscard]] std::optional<Phrase> next_phrase(const FollowedWay& way, const std::string& left,
                                                const Phrasebook& phrases);
// "You are there: the bed ahead, in reach."
[[nodiscard]] Phrase there_phrase(const Goal& goal, const Pose& pose);
// And then: how wide the door is, what it lies on, how high to reach, and what a helper noted.
[[nodiscard]] std::vector<Phrase> at_goal_phrases(const Goal& goal, const Wording& wording);

}  // namespace roomwise::guide
