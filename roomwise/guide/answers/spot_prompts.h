#pragma once

#include <string>
#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

// What is said of places that people mark to come back to: "my chair".
namespace roomwise::guide {

// Spots that people do not name, as the catalogues' goals call them: where somebody last asked that
// their place be remembered, and where they stood when they were last led somewhere.
inline constexpr const char* kRememberedPlace = "remembered place";
inline constexpr const char* kStartingPlace = "starting place";

enum class SpotStep {
  kMarked,     // here, by a name or without one
  kNotSure,    // where one stands is not known well enough
  kOtherName,  // that name means something else
  kBadName,    // it is too long to be spoken, or no words
  kTooMany,
  kForgotten,
  kNotErased,  // it is forgotten, and not erased yet
  kRenamed,    // `name`: the new one
  kNotYours,   // nothing of that name, or somebody else's
  kNoWayBack,  // nobody knows where one set out
  kBusy,       // the computer maps or learns
};

// `name`: of the spot; empty: of one without a name.
[[nodiscard]] Prompt spot_prompt(SpotStep step, const std::string& name, const Wording& wording,
                                 TimestampNs now_ns, const std::string& because = {});
// "which places did I mark". Never empty.
[[nodiscard]] std::vector<Prompt> spots_prompts(const std::vector<std::string>& names,
                                                const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
