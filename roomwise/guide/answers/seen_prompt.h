#pragma once

#include <optional>
#include <string>

#include "roomwise/base/calendar_time.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// "Seen this morning.", "Seen on 25 November.": a later part of an answer, without a sound. Nothing
// where a time is not known, or a clock is wrong: it was not seen yet.
[[nodiscard]] std::optional<Prompt> seen_prompt(std::string key,
                                                const std::optional<CalendarTime>& seen,
                                                const std::optional<CalendarTime>& today,
                                                const Wording& wording, TimestampNs now_ns,
                                                std::string because);

}  // namespace roomwise::guide
