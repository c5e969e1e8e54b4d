#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/calendar_time.h"
#include "roomwise/guide/questions/understand.h"
#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// Where a picture of the home may show what no label names, and when it was taken.
struct SeenWord {
  std::optional<std::string> room;
  std::optional<CalendarTime> seen;
};

// What to look for in pictures, where somebody asked for a thing that the home does not know: in
// English, as networks of pictures and words read it. Nothing where only another language has it.
[[nodiscard]] std::optional<std::string> word_to_look_for(const Understood& heard,
                                                          const Phrasebook& phrases);

// To who asked for it: that it is not known, and looked for.
[[nodiscard]] std::vector<Prompt> looking_prompts(const std::string& thing, const Wording& wording,
                                                  TimestampNs now_ns);
// What came of it, a while later; never as certain.
[[nodiscard]] std::vector<Prompt> word_prompts(const std::string& thing,
                                               const std::optional<SeenWord>& seen,
                                               const std::optional<CalendarTime>& today,
                                               const Wording& wording, TimestampNs now_ns);

}  // namespace roomwise::guide
