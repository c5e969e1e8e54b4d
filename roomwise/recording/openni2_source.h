#pragma once

#include <memory>
#include <optional>
#include <string>

#include "roomwise/recording/frame_source.h"

namespace roomwise::recording {

struct OpenNi2Options {
  // Which device: empty for the first one found, a device's URI, or the path of an .oni recording.
  std::string uri;
  // Replaces the intrinsics that the device reports (its nominal field of view), for example by a
  // calibration. Its size must be the colour image's; the unit of depth stays the device's.
  std::optional<geometry::PinholeCamera> camera;
  // The longest wait for a frame, s.
  double timeout_s = 5;

  [[nodiscard]] Expected<void> validate() const;
};

// A depth camera that OpenNI 2 knows (Asus Xtion, the first Kinect), or an .oni recording of one:
// colour and depth at 640x480, 30 frames a second, depth registered to colour, not mirrored, time
// stamps of the device. The two streams are synchronised by the device where it can; in any case a
// frame is a colour and a depth image at most half a frame period apart. Frames are raw pixels.
// OpenNI's own drivers know the Xtion; on Linux the first Kinect needs libfreenect's driver beside
// them.
//
// An .oni recording gives the streams as they were recorded (it must have been recorded with
// registration on; the file does not say) and ends; a live camera never does. OpenNI's recorder
// lets each stream's clock begin at 0, so a recording whose streams began apart pairs them wrongly
// by as much.
//
// The tests drive it through OpenNI 2 itself with a made-up device and .oni files recorded from it.
// No real camera has been tried yet.
class OpenNi2Source final : public FrameSource {
 public:
  // Fails where there is no device, no colour or depth stream, no such mode or no registration.
  [[nodiscard]] static Expected<std::unique_ptr<OpenNi2Source>> open(const OpenNi2Options& options);

  ~OpenNi2Source() override;

  [[nodiscard]] const SourceInfo& info() const override;
  // Fails where the device gives no frame within the time allowed, or is gone.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override;
  void skip_before(std::uint64_t index) override;

 private:
  class Session;
  explicit OpenNi2Source(std::unique_ptr<Session> session);

  std::unique_ptr<Session> session_;
};

}  // namespace roomwise::recording
