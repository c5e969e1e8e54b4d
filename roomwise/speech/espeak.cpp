#include "roomwise/speech/espeak.h"

#include <espeak-ng/speak_lib.h>

#include <mutex>

namespace roomwise::speech {
namespace {

// espeak-ng hands the sound of the one text that is being spoken over to this.
int collect(short* samples, int count, espeak_EVENT* events) {
  auto* pcm = static_cast<Pcm*>(events->user_data);
  if (samples != nullptr && pcm != nullptr) {
    pcm->samples.insert(pcm->samples.end(), samples, samples + count);
  }
  return 0;
}

// The sample rate, or less than 1 where there is no data. Once a process.
int initialize() {
  const int rate_hz =
      espeak_Initialize(AUDIO_OUTPUT_SYNCHRONOUS, 0, nullptr, espeakINITIALIZE_DONT_EXIT);
  if (rate_hz > 0) espeak_SetSynthCallback(collect);
  return rate_hz;
}

}  // namespace

Expected<Pcm> synthesize(const std::string& text, const std::string& language,
                         int words_per_minute) {
  if (words_per_minute < espeakRATE_MINIMUM || words_per_minute > espeakRATE_MAXIMUM) {
    return fail("{} words a minute; expected {} to {}", words_per_minute, espeakRATE_MINIMUM,
                espeakRATE_MAXIMUM);
  }
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  static const int rate_hz = initialize();
  if (rate_hz <= 0) return fail("espeak-ng finds no voices; install espeak-ng-data");
  if (espeak_SetVoiceByName(language.c_str()) != EE_OK) {
    return fail("espeak-ng has no voice \"{}\"; install espeak-ng-data", language);
  }
  if (espeak_SetParameter(espeakRATE, words_per_minute, 0) != EE_OK) {
    return fail("espeak-ng does not take {} words a minute", words_per_minute);
  }
  Pcm pcm{rate_hz, {}};
  if (espeak_Synth(text.c_str(), text.size() + 1, 0, POS_CHARACTER, 0, espeakCHARS_UTF8, nullptr,
                   &pcm) != EE_OK) {
    return fail("espeak-ng could not speak \"{}\"", text);
  }
  return pcm;
}

}  // namespace roomwise::speech
