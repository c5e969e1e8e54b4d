#include "roomwise/speech/recorded_speaker.h"

#include <cmath>

#include "roomwise/speech/earcons.h"
#include "roomwise/speech/espeak.h"

namespace roomwise::speech {
namespace {

constexpr double kPause_s = 0.08;  // between the sound and the words

}  // namespace

Expected<Pcm> spoken(const guide::Prompt& prompt, int words_per_minute) {
  ROOMWISE_TRY(const Pcm words, synthesize(prompt.text, prompt.language, words_per_minute));
  Pcm pcm = earcon(prompt.sound, words.rate_hz);
  if (!pcm.samples.empty()) {
    const auto pause = static_cast<std::size_t>(kPause_s * words.rate_hz);
    pcm.samples.resize(pcm.samples.size() + pause);
  }
  pcm.samples.insert(pcm.samples.end(), words.samples.begin(), words.samples.end());
  return pcm;
}

Expected<void> RecordedSpeaker::begin(const guide::Utterance& utterance, TimestampNs now_ns) {
  ROOMWISE_TRY(const Pcm pcm, spoken(utterance.prompt, words_per_minute_));
  ROOMWISE_RETURN_IF_ERROR(timeline_.place(now_ns, pcm));
  done_ns_ = now_ns + std::llround(pcm.duration_s() * 1e9);
  return {};
}

Expected<void> RecordedSpeaker::stop(TimestampNs now_ns) {
  done_ns_ = now_ns;
  return timeline_.cut(now_ns);
}

}  // namespace roomwise::speech
