#pragma once

#include <deque>
#include <functional>
#include <future>
#include <optional>

#include "roomwise/base/thread_pool.h"
#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// The frames of a recording as its next() gives them, a few of them read ahead on a pool's threads;
// of one that is read in order (a video), one.
class ReadAheadSource final : public FrameSource {
 public:
  using Prepare = std::function<image::RgbdFrame(image::RgbdFrame)>;

  // Both must outlive it, and nobody else is to take the recording's frames. `prepare` is done to
  // each frame on these threads, too.
  ReadAheadSource(Recording& recording, ThreadPool& pool, Prepare prepare);
  ~ReadAheadSource() override;
  ReadAheadSource(const ReadAheadSource&) = delete;
  ReadAheadSource& operator=(const ReadAheadSource&) = delete;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override;
  void skip_before(std::uint64_t index) override;

 private:
  using Frame = Expected<std::optional<image::RgbdFrame>>;
  struct Ahead {
    std::optional<std::uint64_t> index;  // absent: an error that belongs to no frame
    std::future<Frame> frame;
  };
  void read_ahead();
  void count_what_is_left();

  Recording& recording_;
  ThreadPool& pool_;
  Prepare prepare_;
  std::size_t depth_;
  SourceInfo info_;
  std::deque<Ahead> ahead_;
};

}  // namespace roomwise::recording
