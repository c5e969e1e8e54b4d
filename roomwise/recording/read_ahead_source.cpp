#include "roomwise/recording/read_ahead_source.h"

#include <algorithm>
#include <utility>

namespace roomwise::recording {

ReadAheadSource::ReadAheadSource(Recording& recording, ThreadPool& pool, Prepare prepare)
    : recording_(recording),
      pool_(pool),
      prepare_(std::move(prepare)),
      depth_(recording.reads_in_order() ? 1 : pool.size() + 1),
      info_(recording.info()) {}

ReadAheadSource::~ReadAheadSource() {
  for (const Ahead& one : ahead_) one.frame.wait();
}

void ReadAheadSource::read_ahead() {
  while (ahead_.size() < depth_) {
    auto index = recording_.next_index();
    if (index && !*index) return;
    const std::optional<std::uint64_t> known = index ? *index : std::nullopt;
    ahead_.push_back({known, pool_.submit([this, index = std::move(index)]() -> Frame {
                        if (!index) return Unexpected(index.error());
                        ROOMWISE_TRY(auto frame, recording_.frame(**index));
                        if (frame) frame = prepare_(*std::move(frame));
                        return frame;
                      })});
  }
}

void ReadAheadSource::count_what_is_left() {
  const auto read =
      std::ranges::count_if(ahead_, [](const Ahead& one) { return one.index.has_value(); });
  info_.frames_remaining = *recording_.info().frames_remaining + static_cast<std::uint64_t>(read);
}

Expected<std::optional<image::RgbdFrame>> ReadAheadSource::next() {
  read_ahead();
  if (ahead_.empty()) return std::optional<image::RgbdFrame>();
  Ahead first = std::move(ahead_.front());
  ahead_.pop_front();  // also where it throws
  Frame frame = first.frame.get();
  count_what_is_left();
  read_ahead();  // while the caller works
  return frame;
}

void ReadAheadSource::skip_before(std::uint64_t index) {
  while (!ahead_.empty() && ahead_.front().index && *ahead_.front().index < index) {
    ahead_.front().frame.wait();
    ahead_.pop_front();
  }
  recording_.skip_before(index);
  count_what_is_left();
}

}  // namespace roomwise::recording
