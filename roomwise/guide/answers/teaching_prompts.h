#pragma once

#include <string>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"
#include "roomwise/objects/own_things/shown_thing.h"

// What is said to somebody who teaches a thing, and of things that were taught.
namespace roomwise::guide {

enum class TeachingStep {
  kBegin,               // show it
  kGoOn,                // half of it is there: turn it
  kEnough,              // what is it called?
  kMore,                // a name came before enough was shown
  kLearning,            // one moment
  kTaught,              // from now on it is looked for
  kTaughtNotLookedFor,  // it is known, but nothing is looked for yet: the home has no walk
  kOtherName,           // that name means something else, or is another thing's
  kTooMany,             // no more things are looked for
  kNoCamera,
  kFailed,
  kStopped,
  kForgotten,
  kNotErased,  // it is forgotten, and not erased yet
  kShared,
  kKept,    // its owner's alone
  kNotOwn,  // somebody else taught it, or nobody
  kBusy,    // the computer maps or learns
};

// `name`: of the thing, where the step has one.
[[nodiscard]] Prompt teaching_prompt(TeachingStep step, const std::string& name,
                                     const Wording& wording, TimestampNs now_ns,
                                     const std::string& because = {});
// What to do about a picture that shows nothing to learn from.
[[nodiscard]] Prompt fault_prompt(objects::ShowFault fault, const Wording& wording,
                                  TimestampNs now_ns);

}  // namespace roomwise::guide
