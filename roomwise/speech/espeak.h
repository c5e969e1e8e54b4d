#pragma once

#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/speech/pcm.h"

namespace roomwise::speech {

// What espeak-ng makes of a text, in the voice of the language ("en", "de"), without a sound card.
// One call at a time: espeak-ng has one state a process, and others wait. Fails where espeak-ng's
// data or the language is missing, and on rates outside of 80 to 450 words a minute.
[[nodiscard]] Expected<Pcm> synthesize(const std::string& text, const std::string& language,
                                       int words_per_minute);

}  // namespace roomwise::speech
