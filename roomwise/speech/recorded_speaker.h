#pragma once

#include "roomwise/speech/speaker.h"
#include "roomwise/speech/wav_timeline.h"

namespace roomwise::speech {

// Speaks into a file, by espeak-ng, so that what was said on a walk can be listened to: everything
// stands where it was heard. It is done when the words would have been heard, on the caller's
// clock.
class RecordedSpeaker : public Speaker {
 public:
  // The timeline's rate must be kRate_hz.
  RecordedSpeaker(WavTimeline timeline, int words_per_minute)
      : timeline_(std::move(timeline)), words_per_minute_(words_per_minute) {}

  static constexpr int kRate_hz = 22050;  // espeak-ng's

  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance,
                                     TimestampNs now_ns) override;
  [[nodiscard]] Expected<void> stop(TimestampNs now_ns) override;
  [[nodiscard]] Expected<bool> is_done(TimestampNs now_ns) override { return now_ns >= done_ns_; }
  // When what was begun will have been heard.
  [[nodiscard]] TimestampNs done_ns() const { return done_ns_; }

 private:
  WavTimeline timeline_;
  int words_per_minute_;
  TimestampNs done_ns_ = std::numeric_limits<TimestampNs>::min();
};

// The sound of a prompt, a moment of silence, and its words.
[[nodiscard]] Expected<Pcm> spoken(const guide::Prompt& prompt, int words_per_minute);

}  // namespace roomwise::speech
