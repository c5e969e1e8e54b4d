#include "device_camera.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::app {
namespace {

constexpr int kQuality = 90;       // of JPEG, where the camera gives raw pixels
constexpr int kSmallQuality = 40;  // for a slow network: some 20 kB for 640x480

Bytes message_of(const image::RgbdFrame& frame, double t_ms) {
  const Bytes color =
      frame.encoded_color.empty() ? image::encode_jpeg(frame.color, kQuality) : frame.encoded_color;
  const Bytes depth =
      frame.encoded_depth.empty() ? image::encode_png(frame.depth) : frame.encoded_depth;
  return service::write(service::FrameMessage{t_ms, color, depth});
}

Bytes small_message_of(const image::RgbdFrame& frame, double t_ms) {
  const Bytes color = image::encode_jpeg(frame.color, kSmallQuality);
  return service::write(service::FrameMessage{t_ms, color, {}});
}

}  // namespace

TimestampNs steady_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

DeviceCamera::DeviceCamera(std::unique_ptr<recording::FrameSource> source, const CameraPace& pace,
                           Reopen reopen)
    : source_(std::move(source)),
      info_(source_->info()),
      pace_(pace),
      reopen_(std::move(reopen)),
      began_ns_(steady_now_ns()) {
  thread_ = std::thread([this] { run(); });
}

DeviceCamera::~DeviceCamera() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  closing_changed_.notify_all();
  thread_.join();
}

std::optional<DeviceCamera::Frame> DeviceCamera::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(newest_, std::nullopt);
}

bool DeviceCamera::ended() const {
  const std::scoped_lock lock(mutex_);
  return ended_ && !newest_;
}

std::optional<std::string> DeviceCamera::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

void DeviceCamera::run() {
  for (;;) {
    const auto frame = source_->next();
    if (!frame || !*frame) {
      const std::unique_lock lock(mutex_);
      if (!frame) failure_ = frame.error().message;
      ended_ = frame || !reopen_;
      if (ended_) return;
    }
    if (!frame) {
      if (!reopen()) return;
      continue;
    }
    if (!wait_for((*frame)->timestamp_ns)) return;
    const double t_ms = static_cast<double>(steady_now_ns()) * 1e-6;
    Frame taken{t_ms, small_ ? small_message_of(**frame, t_ms) : message_of(**frame, t_ms)};
    const std::scoped_lock lock(mutex_);
    newest_ = std::move(taken);
    failure_.reset();
  }
}

bool DeviceCamera::reopen() {
  source_.reset();  // it may be the only one that can be open
  while (!source_) {
    std::unique_lock lock(mutex_);
    const auto pause = std::chrono::duration<double>(pace_.reopen_s);
    if (closing_changed_.wait_for(lock, pause, [&] { return closing_; })) return false;
    lock.unlock();
    auto opened = reopen_();
    // Another camera's pictures would be taken for this one's.
    if (opened && (*opened)->info().camera == info_.camera) source_ = *std::move(opened);
  }
  return true;
}

bool DeviceCamera::wait_for(TimestampNs timestamp_ns) {
  std::unique_lock lock(mutex_);
  const bool is_live = !info_.frames_remaining;
  if (!first_ns_) first_ns_ = timestamp_ns;
  const double due_s = pace_.recorded ? seconds_between(*first_ns_, timestamp_ns)
                                      : static_cast<double>(taken_++) / pace_.rate_hz;
  const std::chrono::nanoseconds due(began_ns_ + std::llround(due_s / kSecondsPerNs));
  if (!is_live) {
    closing_changed_.wait_until(lock, std::chrono::steady_clock::time_point(due),
                                [&] { return closing_; });
  }
  return !closing_;
}

}  // namespace roomwise::app
