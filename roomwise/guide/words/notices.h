#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/guide/words/prompt_queue.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// A message of the device itself, "device.connection_lost". Its key is the message without what
// stands after '_', so that "device.connection_back" takes its place where it still waits.
[[nodiscard]] Prompt notice_prompt(const std::string& message, Sound sound, const Wording& wording,
                                   TimestampNs now_ns);

// What was said last again, as an answer. What is past its time is said with "Earlier:" before it,
// and after a minute not at all: a direction of then would be taken for one of now.
[[nodiscard]] std::vector<Prompt> repeat_prompts(const std::optional<Said>& last_said,
                                                 const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
