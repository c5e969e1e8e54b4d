#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/image/personal_data.h"
#include "roomwise/image/rgbd_frame.h"

namespace roomwise::recording {

struct SourceInfo {
  std::string name;  // for people: the folder of a recording, the model of a camera
  geometry::PinholeCamera camera;
  std::optional<std::uint64_t>
      frames_remaining;  // RGB-D frames still to come; absent for a live camera
  // Of a live camera, so far: what came damaged, or came while nobody took it.
  std::uint64_t lost_frames = 0;
  // What the source says that is nobody's business. It is in no frame.
  image::PersonalData personal_data = {};
};

// Where RGB-D frames come from: a recording, a live camera, the network, a simulated home. Frames
// come in the order of time, each at most once. Not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  [[nodiscard]] virtual const SourceInfo& info() const = 0;
  // The next frame; nothing at the end of a recording. An error leaves the source at the frame
  // after it.
  [[nodiscard]] virtual Expected<std::optional<image::RgbdFrame>> next() = 0;
  // Passes over the frames whose index is below `index` without decoding them. A live camera
  // ignores it.
  virtual void skip_before(std::uint64_t index) = 0;
};

// Where RGB-D frames go.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  [[nodiscard]] virtual Expected<void> write(const image::RgbdFrame& frame) = 0;
  // Completes what was written; the sink takes nothing afterwards.
  [[nodiscard]] virtual Expected<void> close() = 0;
};

}  // namespace roomwise::recording
