#pragma once

#include <span>
#include <string>

#include "laboratory/trials/guidance/guidance_trial.h"

namespace roomwise::trials {

// A page that shows each walk from above, with what was heard where: the numbers on the path are
// those of the list beside it.
[[nodiscard]] std::string guidance_page(const WalkedHome& home, std::span<const GuidedWalk> walks,
                                        const std::string& title, const std::string& note);

}  // namespace roomwise::trials
