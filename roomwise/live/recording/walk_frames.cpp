#include "roomwise/live/recording/walk_frames.h"

#include "roomwise/recording/camera_file.h"

namespace roomwise::live {

Expected<std::unique_ptr<WalkFrames>> WalkFrames::open(std::shared_ptr<const WalkRecorder> walk,
                                                       const Interruption& interruption) {
  // As it stands in the folder, so that a map can be gone on with from there.
  ROOMWISE_TRY(const auto camera, recording::read_camera(walk->folder() / "camera.txt"));
  recording::SourceInfo info{walk->name(), camera, {}};
  return std::unique_ptr<WalkFrames>(
      new WalkFrames(std::move(info), std::move(walk), interruption));
}

Expected<std::optional<image::RgbdFrame>> WalkFrames::next() {
  const bool is_there = walk_->wait_for_frame(next_, interruption_);
  if (interruption_.interrupted()) {
    return fail_with(ErrorCode::kInterrupted, "stopped while the walk was recorded");
  }
  if (!is_there) return std::optional<image::RgbdFrame>();
  const std::uint64_t index = next_++;  // also where it cannot be read
  if (!stored_ || index >= stored_->colors().size()) {
    ROOMWISE_TRY(stored_, recording::TumRecording::open(walk_->folder()));
  }
  return stored_->frame(index);
}

}  // namespace roomwise::live
