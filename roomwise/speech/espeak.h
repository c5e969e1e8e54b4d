#pragma once

#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/speech/pcm.h"

namespace roomwise::speech {

// What the program espeak-ng makes of a text (UTF-8, at most 4,096 bytes), in the voice of the
// language ("en", "de"), without a sound card. Fails where espeak-ng or the language is missing,
// and on rates outside of 80 to 450 words a minute.
[[nodiscard]] Expected<Pcm> synthesize(const std::string& text, const std::string& language,
                                       int words_per_minute);

}  // namespace roomwise::speech
