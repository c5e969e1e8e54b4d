#pragma once

#include <vector>

#include "roomwise/guide/questions/understand.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// What can be asked in this home, by examples that understand() knows. Never empty.
[[nodiscard]] std::vector<Prompt> example_prompts(const HomeNames& home, const Wording& wording,
                                                  TimestampNs now_ns);

// The answer where the outcome is no question: what was not understood, then what can be asked; or
// which one, or whether the nearest is meant. Never empty.
[[nodiscard]] std::vector<Prompt> refusal_prompts(const Understood& heard, const HomeNames& home,
                                                  const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
