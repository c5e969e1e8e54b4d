#pragma once

#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::trials {

// What somebody who hears a prompt takes from it, by its words and numbers alone.
struct Instruction {
  enum class Kind {
    kNothing,  // tells, asks for nothing
    kStop,
    kTurn,        // on the spot, then stand
    kLittle,      // a little to a side, walking or standing
    kWalk,        // straight on, then stand
    kSoon,        // walk so far, then turn
    kLookAround,  // stop and turn slowly
    kStairs,      // over the stairs that one stands before, then stand
  };
  Kind kind = Kind::kNothing;
  double turn_rad = 0;    // positive to the left
  double distance_m = 0;  // by steps as the guide counts them
};
[[nodiscard]] Instruction understand(const guide::Prompt& prompt, const guide::Wording& wording);

// A leg of the list that "way to" answers with at once: a turn, then a walk.
[[nodiscard]] std::vector<Instruction> understand_leg(const guide::Prompt& prompt,
                                                      const guide::Wording& wording);

}  // namespace roomwise::trials
