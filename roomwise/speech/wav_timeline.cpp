#include "roomwise/speech/wav_timeline.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#include "roomwise/base/file.h"

namespace roomwise::speech {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are written as they lie");

constexpr std::int64_t kHeaderBytes = 44;
constexpr std::int64_t kMaxSamples =
    (std::int64_t{std::numeric_limits<std::uint32_t>::max()} - kHeaderBytes) / 2;

// RIFF's header of uncompressed sound, one channel of 16 bits.
std::array<std::uint8_t, kHeaderBytes> header_of(int rate_hz, std::int64_t samples) {
  std::array<std::uint8_t, kHeaderBytes> header{};
  std::size_t at = 0;
  const auto text = [&](const char* four) {
    std::memcpy(header.data() + at, four, 4);
    at += 4;
  };
  const auto number = [&](std::int64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) header[at++] = static_cast<std::uint8_t>(value >> (8 * i));
  };
  text("RIFF");
  number(kHeaderBytes - 8 + 2 * samples, 4);
  text("WAVE");
  text("fmt ");
  number(16, 4);  // bytes of this part
  number(1, 2);   // uncompressed
  number(1, 2);   // channels
  number(rate_hz, 4);
  number(2 * std::int64_t{rate_hz}, 4);  // bytes a second
  number(2, 2);                          // bytes of all channels
  number(16, 2);                         // bits
  text("data");
  number(2 * samples, 4);
  return header;
}

Expected<void> check_may_overwrite(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) || std::filesystem::file_size(path, error) == 0) {
    return {};
  }
  std::array<char, 12> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  const bool is_wav =
      std::memcmp(head.data(), "RIFF", 4) == 0 && std::memcmp(head.data() + 8, "WAVE", 4) == 0;
  if (!is_wav) return fail("{} is no WAV file; give another name", path.string());
  return {};
}

}  // namespace

std::vector<std::uint8_t> wav_bytes(const Pcm& pcm) {
  const auto header = header_of(pcm.rate_hz, static_cast<std::int64_t>(pcm.samples.size()));
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.resize(header.size() + 2 * pcm.samples.size());
  std::memcpy(bytes.data() + header.size(), pcm.samples.data(), 2 * pcm.samples.size());
  return bytes;
}

Expected<WavTimeline> WavTimeline::create(const std::filesystem::path& path, TimestampNs begin_ns,
                                          int rate_hz) {
  if (rate_hz < 4000 || rate_hz > 192000) {
    return fail("rate_hz is {}; expected 4000 to 192000", rate_hz);
  }
  ROOMWISE_RETURN_IF_ERROR(check_may_overwrite(path));
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return fail("{}: {}", path.string(), std::strerror(errno));
  WavTimeline timeline(path, descriptor, begin_ns, rate_hz);
  ROOMWISE_RETURN_IF_ERROR(timeline.write_header());
  return timeline;
}

WavTimeline::~WavTimeline() {
  if (descriptor_ >= 0) close(descriptor_);
}

WavTimeline::WavTimeline(WavTimeline&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      begin_ns_(other.begin_ns_),
      rate_hz_(other.rate_hz_),
      samples_(other.samples_) {}

Expected<std::int64_t> WavTimeline::sample_at(TimestampNs at_ns) const {
  if (at_ns < begin_ns_) {
    return fail("{}: {} s before its beginning", path_.string(), seconds_between(at_ns, begin_ns_));
  }
  const auto sample = std::llround(seconds_between(begin_ns_, at_ns) * rate_hz_);
  if (sample > kMaxSamples) return fail("{}: a WAV file holds 4 GB at most", path_.string());
  return sample;
}

Expected<void> WavTimeline::place(TimestampNs at_ns, const Pcm& pcm) {
  if (pcm.rate_hz != rate_hz_) {
    return fail("{}: a sound of {} Hz; the file has {} Hz", path_.string(), pcm.rate_hz, rate_hz_);
  }
  ROOMWISE_TRY(const std::int64_t first, sample_at(at_ns));
  const auto count = static_cast<std::int64_t>(pcm.samples.size());
  if (count > kMaxSamples - first) {
    return fail("{}: a WAV file holds 4 GB at most", path_.string());
  }
  ROOMWISE_RETURN_IF_ERROR(set_length(first));
  // The sound first, then the sizes that count it: a program that is killed between leaves a file
  // without the last sound.
  ROOMWISE_RETURN_IF_ERROR(
      write(kHeaderBytes + 2 * first, pcm.samples.data(), 2 * pcm.samples.size()));
  samples_ = first + count;
  return write_header();
}

Expected<void> WavTimeline::cut(TimestampNs at_ns) {
  ROOMWISE_TRY(const std::int64_t first, sample_at(at_ns));
  return first < samples_ ? set_length(first) : Expected<void>();
}

Expected<void> WavTimeline::extend(TimestampNs to_ns) {
  ROOMWISE_TRY(const std::int64_t end, sample_at(to_ns));
  return end > samples_ ? set_length(end) : Expected<void>();
}

// The sizes in the header never count more than there is.
Expected<void> WavTimeline::set_length(std::int64_t samples) {
  const bool is_shorter = samples < samples_;
  samples_ = samples;
  if (is_shorter) ROOMWISE_RETURN_IF_ERROR(write_header());
  if (ftruncate(descriptor_, kHeaderBytes + 2 * samples) != 0) {
    return fail("{}: {}", path_.string(), std::strerror(errno));
  }
  return is_shorter ? Expected<void>() : write_header();
}

Expected<void> WavTimeline::write_header() {
  const auto header = header_of(rate_hz_, samples_);
  return write(0, header.data(), header.size());
}

Expected<void> WavTimeline::write(std::int64_t offset, const void* bytes, std::size_t size) {
  const auto* rest = static_cast<const std::uint8_t*>(bytes);
  while (size > 0) {
    const ssize_t written = pwrite(descriptor_, rest, size, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return fail("{}: {}", path_.string(), std::strerror(errno));
    rest += written;
    offset += written;
    size -= static_cast<std::size_t>(written);
  }
  return {};
}

}  // namespace roomwise::speech
