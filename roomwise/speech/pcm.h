#pragma once

#include <cstdint>
#include <vector>

namespace roomwise::speech {

// Sound: one channel of 16-bit samples.
struct Pcm {
  int rate_hz = 0;
  std::vector<std::int16_t> samples;

  [[nodiscard]] double duration_s() const {
    return rate_hz > 0 ? static_cast<double>(samples.size()) / rate_hz : 0;
  }
};

}  // namespace roomwise::speech
