#include "roomwise/speech/earcons.h"

#include <cmath>
#include <numbers>

namespace roomwise::speech {
namespace {

struct Tone {
  double hz = 0;  // 0: silence
  double duration_s = 0;
};

std::vector<Tone> tones_of(guide::Sound sound) {
  switch (sound) {
    case guide::Sound::kAnswer:
      return {{659.3, 0.07}, {987.8, 0.11}};
    case guide::Sound::kUnsure:
      return {{392.0, 0.1}, {0, 0.04}, {392.0, 0.12}};
    case guide::Sound::kLost:
      return {{587.3, 0.1}, {440.0, 0.1}, {293.7, 0.16}};
    case guide::Sound::kBack:
      return {{293.7, 0.1}, {440.0, 0.1}, {587.3, 0.16}};
    case guide::Sound::kAlert:
      return {{1568.0, 0.04}, {0, 0.02}, {1568.0, 0.04}, {0, 0.02}, {1568.0, 0.04}};
    case guide::Sound::kNone:
      break;
  }
  return {};
}

constexpr double kPeak = 0.4 * 32767;  // about as loud as the voice
constexpr double kRamp_s = 0.006;      // tones that begin or end at once click

void append(Tone tone, Pcm& pcm) {
  const auto count = static_cast<int>(std::lround(tone.duration_s * pcm.rate_hz));
  for (int i = 0; i < count; ++i) {
    const double time_s = static_cast<double>(i) / pcm.rate_hz;
    const double edge_s = std::min(time_s, static_cast<double>(count - i) / pcm.rate_hz);
    const double loudness = std::min(1.0, edge_s / kRamp_s);
    const double phase = 2 * std::numbers::pi * tone.hz * time_s;
    // A little of the octave makes it heard on small speakers too.
    const double value = 0.8 * std::sin(phase) + 0.2 * std::sin(2 * phase);
    pcm.samples.push_back(static_cast<std::int16_t>(std::lround(kPeak * loudness * value)));
  }
}

}  // namespace

Pcm earcon(guide::Sound sound, int rate_hz) {
  Pcm pcm{rate_hz, {}};
  for (const Tone& tone : tones_of(sound)) append(tone, pcm);
  return pcm;
}

}  // namespace roomwise::speech
