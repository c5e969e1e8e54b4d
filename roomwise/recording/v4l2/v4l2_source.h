#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomwise/recording/frame_source.h"
#include "roomwise/recording/v4l2/rgbd_calibration.h"
#include "roomwise/recording/v4l2/video_kernel.h"

namespace roomwise::recording {

struct V4l2Options {
  // Of the depth, then of the colour: "/dev/video2". Empty: the first camera with depth that is
  // found; without colour: that of the same camera.
  std::string depth_device, color_device;
  // The kernel knows neither a camera's lenses nor its unit of depth.
  RgbdCalibration calibration;
  // The fastest rate that is asked for.
  double max_rate_hz = 30;
  // The longest wait for a frame, s.
  double timeout_s = 5;

  [[nodiscard]] Expected<void> validate() const;
};

// A depth camera that the kernel's uvcvideo driver, or another of its video drivers, knows, as
// RealSense's: a node whose pictures are Z16, beside one with colour (YUYV, UYVY, RGB3, BGR3,
// MJPG), told apart by these formats. Streams are set to the sizes of the calibration. A frame is a
// colour and a depth picture at most half a period apart by the kernel's clock, the depth moved to
// the colour camera, with at most 640 px a side. A picture that came damaged is left out and
// counted, also in info().lost_frames.
//
// The tests drive it with a made-up driver. No real camera has been tried yet.
class V4l2Source final : public FrameSource {
 public:
  // Fails, saying what there is instead, where there is no such camera, or no such size.
  [[nodiscard]] static Expected<std::unique_ptr<V4l2Source>> open(
      const V4l2Options& options, std::shared_ptr<VideoKernel> kernel = linux_video_kernel());

  ~V4l2Source() override;

  [[nodiscard]] const SourceInfo& info() const override;
  // Fails where the camera gives no frame within the time allowed, or is gone.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override;
  void skip_before(std::uint64_t) override {}

 private:
  class Session;
  explicit V4l2Source(std::unique_ptr<Session> session);

  std::unique_ptr<Session> session_;
};

// The cameras that are there, a line each: where, what they are called, what they give.
[[nodiscard]] std::string describe_video_cameras(
    const std::shared_ptr<VideoKernel>& kernel = linux_video_kernel());

}  // namespace roomwise::recording
