#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>
#include <string>

#include "roomwise/base/file.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/speech/pcm.h"

// Looks into sounds. Only for tests.
namespace roomwise::speech::testing {

constexpr TimestampNs kSecond = 1'000'000'000;

// How much of a frequency is in a sound (Goertzel's algorithm, written as a sum).
inline double strength(const Pcm& pcm, double hz) {
  double along = 0;
  double across = 0;
  for (std::size_t i = 0; i < pcm.samples.size(); ++i) {
    const double phase = 2 * std::numbers::pi * hz * static_cast<double>(i) / pcm.rate_hz;
    along += std::cos(phase) * pcm.samples[i];
    across += std::sin(phase) * pcm.samples[i];
  }
  return std::hypot(along, across) / static_cast<double>(pcm.samples.size());
}

inline double loudness(std::span<const std::int16_t> samples) {
  double sum = 0;
  for (const std::int16_t sample : samples) sum += static_cast<double>(sample) * sample;
  return samples.empty() ? 0 : std::sqrt(sum / static_cast<double>(samples.size()));
}

inline Pcm part(const Pcm& pcm, double from_s, double to_s) {
  const auto index = [&](double seconds) {
    return static_cast<std::ptrdiff_t>(std::lround(seconds * pcm.rate_hz));
  };
  return {pcm.rate_hz, {pcm.samples.begin() + index(from_s), pcm.samples.begin() + index(to_s)}};
}

// Reads a WAV file as a player does: by the sizes in its header.
inline Expected<Pcm> read_wav(std::span<const std::uint8_t> bytes) {
  const auto number = [&](std::size_t at, int size) {
    std::uint32_t value = 0;
    for (int i = size; i-- > 0;) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
    return value;
  };
  const auto is = [&](std::size_t at, const char* four) {
    return std::memcmp(bytes.data() + at, four, 4) == 0;
  };
  if (bytes.size() < 44 || !is(0, "RIFF") || !is(8, "WAVE") || !is(12, "fmt ") || !is(36, "data")) {
    return fail("not a plain WAV file");
  }
  const std::uint32_t data_bytes = number(40, 4);
  if (number(20, 2) != 1 || number(22, 2) != 1 || number(34, 2) != 16) return fail("wrong format");
  if (number(4, 4) != data_bytes + 36 || number(28, 4) != 2 * number(24, 4)) {
    return fail("the header's sizes contradict each other");
  }
  if (bytes.size() < 44 + data_bytes) return fail("shorter than its header says");
  Pcm pcm{static_cast<int>(number(24, 4)), {}};
  pcm.samples.resize(data_bytes / 2);
  if (data_bytes > 0) std::memcpy(pcm.samples.data(), bytes.data() + 44, data_bytes);
  return pcm;
}
inline Expected<Pcm> read_wav(const std::filesystem::path& path) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  return read_wav(bytes);
}

}  // namespace roomwise::speech::testing
