#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/guide/questions/understand.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// What can be asked in this home, by examples that understand() knows. Never empty.
[[nodiscard]] std::vector<Prompt> example_prompts(const HomeNames& home, const Wording& wording,
                                                  TimestampNs now_ns);

struct Circumstances {
  std::optional<std::string> room;  // where somebody is, if that is known
  bool is_led = false;              // who has no time for examples
};

// The answer where the outcome is no question: what was not understood, then what can be asked; or
// which one, or whether the nearest is meant; and to an emergency. Never empty.
[[nodiscard]] std::vector<Prompt> refusal_prompts(const Understood& heard, const HomeNames& home,
                                                  const Wording& wording, TimestampNs now_ns,
                                                  const Circumstances& now = {});

}  // namespace roomwise::guide
