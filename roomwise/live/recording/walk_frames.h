#pragma once

#include <cstdint>
#include <memory>

#include "roomwise/live/recording/walk_recorder.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::live {

// The frames of a walk while it is recorded: next() waits for the one after the last until the
// recording is closed, which is the end. They are read from the walk's folder, so that who falls
// behind holds none in memory.
class WalkFrames final : public recording::FrameSource {
 public:
  // next() fails where it is interrupted. `interruption` must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<WalkFrames>> open(
      std::shared_ptr<const WalkRecorder> walk, const Interruption& interruption);

  // Without a frame count: nobody knows how long the walk will be.
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override;
  void skip_before(std::uint64_t index) override { next_ = std::max(next_, index); }

 private:
  WalkFrames(recording::SourceInfo info, std::shared_ptr<const WalkRecorder> walk,
             const Interruption& interruption)
      : info_(std::move(info)), walk_(std::move(walk)), interruption_(interruption) {}

  recording::SourceInfo info_;
  std::shared_ptr<const WalkRecorder> walk_;
  const Interruption& interruption_;
  std::unique_ptr<recording::TumRecording> stored_;  // as far as it was when it was opened
  std::uint64_t next_ = 0;
};

}  // namespace roomwise::live
