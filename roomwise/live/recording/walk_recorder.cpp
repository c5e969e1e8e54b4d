#include "roomwise/live/recording/walk_recorder.h"

#include <algorithm>
#include <cmath>

#include "roomwise/base/stopwatch.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::live {

constexpr double kMinStep_ms = 1;  // between frames: a recording's stamps grow

Expected<std::shared_ptr<WalkRecorder>> WalkRecorder::begin(const std::filesystem::path& folder,
                                                            const service::DeviceCamera& camera,
                                                            TimestampNs begun_ns) {
  if (!camera.calibrated || !camera.has_depth) {
    return fail("this device has no depth camera that is calibrated; a map needs one");
  }
  std::error_code error;
  std::filesystem::create_directories(folder.parent_path(), error);
  if (error) return fail("{}: {}", folder.parent_path().string(), error.message());
  if (std::filesystem::exists(folder)) {
    return fail("there is a recording '{}' already; choose another name",
                folder.filename().string());
  }
  ROOMWISE_TRY(auto writer, recording::TumWriter::create(folder, *camera.calibrated));
  return std::shared_ptr<WalkRecorder>(
      new WalkRecorder(folder, *camera.calibrated, std::move(writer), begun_ns));
}

Expected<bool> WalkRecorder::store(const CameraFrame& frame) {
  const std::scoped_lock lock(mutex_);
  if (closed_) return false;
  if (frame.depth.empty()) {
    ++without_depth_;
    return true;
  }
  // A connection keeps the order of what is sent: the clock stands, went back or began anew.
  std::optional<double> first_t_ms = first_t_ms_;
  if (last_t_ms_ && frame.t_ms < *last_t_ms_ + kMinStep_ms) {
    const double between_ms = std::max(kMinStep_ms, 1e3 * seconds_since(last_came_));
    *first_t_ms += frame.t_ms - *last_t_ms_ - between_ms;
  }
  image::RgbdFrame rgbd;
  rgbd.index = writer_->frames_written();
  rgbd.timestamp_ns =
      begun_ns_ + std::llround((frame.t_ms - first_t_ms.value_or(frame.t_ms)) * 1e6);
  auto images = images_of(frame, {camera_.width, camera_.height, camera_, true});
  if (!images) return Unexpected(std::move(images).error());
  rgbd.color = std::move(images->color);
  if (images->depth) rgbd.depth = std::move(*images->depth);
  // A recording holds JPEG and PNG; a WebP is stored as the writer stores pictures.
  if (images->color_is_as_sent && !image::is_webp(frame.color)) rgbd.encoded_color = frame.color;
  if (images->depth_is_as_sent) rgbd.encoded_depth = frame.depth;
  std::optional<recording::PoseCovariance> covariance;
  if (frame.pose) {
    rgbd.device_motion = frame.pose->motion;
    covariance = frame.pose->covariance;
  }
  ROOMWISE_RETURN_IF_ERROR(writer_->write(rgbd, covariance));
  first_t_ms_ = first_t_ms.value_or(frame.t_ms);
  last_t_ms_ = frame.t_ms;
  last_came_ = std::chrono::steady_clock::now();
  grown_.notify_all();
  return true;
}

Expected<void> WalkRecorder::name_room(const std::string& room) {
  const std::scoped_lock lock(mutex_);
  ROOMWISE_RETURN_IF_ERROR(pipeline::validate_spoken_name(room));
  ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(room));
  return writer_->name_room(room);
}

Expected<void> WalkRecorder::close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  grown_.notify_all();
  return writer_->close();
}

std::uint64_t WalkRecorder::frames() const {
  const std::scoped_lock lock(mutex_);
  return writer_->frames_written();
}

std::uint64_t WalkRecorder::without_depth() const {
  const std::scoped_lock lock(mutex_);
  return without_depth_;
}

bool WalkRecorder::wait_for_frame(std::uint64_t index, const Interruption& interruption) const {
  std::unique_lock lock(mutex_);
  while (writer_->frames_written() <= index) {
    if (closed_ || interruption.interrupted()) return false;
    grown_.wait_for(lock, std::chrono::milliseconds(100));
  }
  return true;
}

}  // namespace roomwise::live
