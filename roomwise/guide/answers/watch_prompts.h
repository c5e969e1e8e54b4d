#pragma once

#include <string>
#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

// What is said of helpers who watch how somebody is led.
namespace roomwise::guide {

// Helpers may watch from now on, or none may.
[[nodiscard]] Prompt may_watch_prompt(bool may_watch, const Wording& wording, TimestampNs now_ns);
// These do. It waits until it is heard.
[[nodiscard]] Prompt watched_prompt(const std::vector<std::string>& names, const Wording& wording,
                                    TimestampNs now_ns);

}  // namespace roomwise::guide
