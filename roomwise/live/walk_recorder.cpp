#include "roomwise/live/walk_recorder.h"

#include <chrono>
#include <cmath>

#include "roomwise/image/codec.h"

namespace roomwise::live {

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

Expected<void> WalkRecorder::store(const CameraFrame& frame) {
  const std::scoped_lock lock(mutex_);
  if (closed_ || (last_t_ms_ && frame.t_ms <= *last_t_ms_)) return {};
  if (frame.depth.empty()) return fail("the frame has no depth image; a map needs one");
  image::RgbdFrame rgbd;
  rgbd.index = writer_->frames_written();
  rgbd.timestamp_ns =
      begun_ns_ + std::llround((frame.t_ms - first_t_ms_.value_or(frame.t_ms)) * 1e6);
  const std::int64_t pixels = std::int64_t{camera_.width} * camera_.height;
  ROOMWISE_TRY(rgbd.color, image::decode_color(frame.color, pixels));
  ROOMWISE_TRY(rgbd.depth, image::decode_depth(frame.depth, pixels));
  const auto fits = [&](const auto& image) {
    return image.width() == camera_.width && image.height() == camera_.height;
  };
  if (!fits(rgbd.color) || !fits(rgbd.depth)) {
    return fail("the images of the frame are not of the camera's {} x {} pixels", camera_.width,
                camera_.height);
  }
  // A recording holds JPEG and PNG; a WebP is stored as the writer stores pictures.
  if (!image::is_webp(frame.color)) rgbd.encoded_color = frame.color;
  rgbd.encoded_depth = frame.depth;
  ROOMWISE_CHECK_OK(writer_->write(rgbd));
  if (!first_t_ms_) first_t_ms_ = frame.t_ms;
  last_t_ms_ = frame.t_ms;
  grown_.notify_all();
  return {};
}

Expected<void> WalkRecorder::name_room(const std::string& room) {
  const std::scoped_lock lock(mutex_);
  ROOMWISE_CHECK_OK(recording::validate_room_name(room));
  return writer_->name_room(room);
}

Expected<void> WalkRecorder::close() {
  const std::scoped_lock lock(mutex_);
  if (closed_) return {};
  closed_ = true;
  grown_.notify_all();
  return writer_->close();
}

std::uint64_t WalkRecorder::frames() const {
  const std::scoped_lock lock(mutex_);
  return writer_->frames_written();
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
