#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "roomwise/base/expected.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::app {

// How fast frames are taken from a recording: as they were recorded, or so many a second. A live
// camera has its own pace.
struct CameraPace {
  bool recorded = true;
  double rate_hz = 10;
  double reopen_s = 2;  // between tries to open a live camera again that failed
};

// The device's camera: a thread that takes frames from a source at their pace and keeps the newest,
// ready to be sent.
class DeviceCamera {
 public:
  struct Frame {
    double t_ms = 0;  // by the device's steady clock, when it was taken
    Bytes message;    // as it is sent
  };

  using Reopen = std::function<Expected<std::unique_ptr<recording::FrameSource>>()>;
  // `reopen`: how a live camera that failed is opened again; none: its failure is its end.
  DeviceCamera(std::unique_ptr<recording::FrameSource> source, const CameraPace& pace,
               Reopen reopen = {});
  ~DeviceCamera();
  DeviceCamera(const DeviceCamera&) = delete;
  DeviceCamera& operator=(const DeviceCamera&) = delete;

  [[nodiscard]] const recording::SourceInfo& info() const { return info_; }
  // From the next frame on: whole, or small for a slow network (the colour image alone, coarsely
  // packed).
  void send_small(bool small) { small_ = small; }
  // The newest frame that was not taken yet.
  [[nodiscard]] std::optional<Frame> take();
  // That there is no more to come: the recording has ended, or failed.
  [[nodiscard]] bool ended() const;
  // Why there are no pictures now; nothing where there are.
  [[nodiscard]] std::optional<std::string> failure() const;

 private:
  void run();
  // Opens the camera again, however often that must be tried; false where it is being closed.
  [[nodiscard]] bool reopen();
  // Waits until the frame is due; false where the camera is being closed.
  [[nodiscard]] bool wait_for(TimestampNs timestamp_ns);

  std::unique_ptr<recording::FrameSource> source_;
  const recording::SourceInfo info_;
  CameraPace pace_;
  Reopen reopen_;
  std::atomic<bool> small_ = false;
  mutable std::mutex mutex_;
  std::condition_variable closing_changed_;
  bool closing_ = false;
  bool ended_ = false;
  std::optional<std::string> failure_;
  std::optional<Frame> newest_;
  std::optional<TimestampNs> first_ns_;
  std::uint64_t taken_ = 0;
  TimestampNs began_ns_ = 0;
  std::thread thread_;  // last: it uses all the others
};

// The device's clock: nanoseconds that only go forward.
[[nodiscard]] TimestampNs steady_now_ns();

}  // namespace roomwise::app
