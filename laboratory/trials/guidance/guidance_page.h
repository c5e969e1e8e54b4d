#pragma once

#include <functional>
#include <span>
#include <string>

#include "laboratory/trials/guidance/guidance_trial.h"

namespace roomwise::trials {

// The home as it was on a walk, by the walk's number.
using HomeOfWalk = std::function<const WalkedHome&(std::size_t)>;

// A page that shows each walk from above, with what was heard where: the numbers on the path are
// those of the list beside it.
[[nodiscard]] std::string guidance_page(std::span<const GuidedWalk> walks,
                                        const HomeOfWalk& home_of, const std::string& title,
                                        const std::string& note);

}  // namespace roomwise::trials
