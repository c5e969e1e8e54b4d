#pragma once

#include "roomwise/guide/words/prompt.h"
#include "roomwise/speech/pcm.h"

namespace roomwise::speech {

// The short sound before the words, made of tones, so that somebody knows what kind of words come
// before they come: an answer rises, "I am not sure" stays low, what is lost falls, what is back
// rises, a hazard knocks. Different in number of tones, pitch and direction; less than half a
// second. Nothing for kNone.
[[nodiscard]] Pcm earcon(guide::Sound sound, int rate_hz);

}  // namespace roomwise::speech
