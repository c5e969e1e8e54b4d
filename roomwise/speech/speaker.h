#pragma once

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/guide/words/prompt_queue.h"

namespace roomwise::speech {

// Speaks what guide::PromptQueue hands out, one utterance at a time:
//
//   if (speaker.is_done(now).value()) queue.finished(id, now);
//   if (auto utterance = queue.next(now)) speaker.begin(*utterance, now);
class Speaker {
 public:
  virtual ~Speaker() = default;

  // Begins with the sound of the prompt, then its words, and returns at once. What is being spoken
  // is broken off.
  [[nodiscard]] virtual Expected<void> begin(const guide::Utterance& utterance,
                                             TimestampNs now_ns) = 0;
  // Breaks off.
  [[nodiscard]] virtual Expected<void> stop(TimestampNs now_ns) = 0;
  // Whether nothing is being spoken any more. Fails where the way to the sound is lost: nothing
  // will be heard then.
  [[nodiscard]] virtual Expected<bool> is_done(TimestampNs now_ns) = 0;
};

}  // namespace roomwise::speech
