#pragma once

#include <cstdint>
#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/speech/pcm.h"

namespace roomwise::speech {

// The sound as the bytes of a WAV file.
[[nodiscard]] std::vector<std::uint8_t> wav_bytes(const Pcm& pcm);

// A WAV file in which sounds stand at the times at which they were heard, with silence between
// them: what was said on a walk. It is written as it goes and is whole after every call, also if
// the program is killed between or within two.
class WavTimeline {
 public:
  // The file begins at `begin_ns`. Overwrites a WAV file, and nothing else that has content.
  [[nodiscard]] static Expected<WavTimeline> create(const std::filesystem::path& path,
                                                    TimestampNs begin_ns, int rate_hz);
  ~WavTimeline();
  WavTimeline(WavTimeline&& other) noexcept;
  WavTimeline& operator=(WavTimeline&&) = delete;

  // Heard from that moment on; what is heard beyond it so far is cut off there. Fails on another
  // rate, before the beginning, and past 4 GB (27 hours at 22,050 Hz).
  [[nodiscard]] Expected<void> place(TimestampNs at_ns, const Pcm& pcm);
  // From that moment on there is nothing yet.
  [[nodiscard]] Expected<void> cut(TimestampNs at_ns);
  // The file lasts to that moment at least, in silence.
  [[nodiscard]] Expected<void> extend(TimestampNs to_ns);

  [[nodiscard]] int rate_hz() const { return rate_hz_; }
  [[nodiscard]] double duration_s() const { return static_cast<double>(samples_) / rate_hz_; }

 private:
  WavTimeline(std::filesystem::path path, int descriptor, TimestampNs begin_ns, int rate_hz)
      : path_(std::move(path)), descriptor_(descriptor), begin_ns_(begin_ns), rate_hz_(rate_hz) {}
  [[nodiscard]] Expected<std::int64_t> sample_at(TimestampNs at_ns) const;
  [[nodiscard]] Expected<void> write(std::int64_t offset, const void* bytes, std::size_t size);
  [[nodiscard]] Expected<void> set_length(std::int64_t samples);
  [[nodiscard]] Expected<void> write_header();

  std::filesystem::path path_;
  int descriptor_ = -1;
  TimestampNs begin_ns_ = 0;
  int rate_hz_ = 0;
  std::int64_t samples_ = 0;
};

}  // namespace roomwise::speech
