#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "roomwise/base/progress.h"
#include "roomwise/live/recording/frame_images.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::live {

// Stores the frames that a device sends as a recording in TUM's format. Thread-safe. A kill loses
// the frame in hand and nothing else.
class WalkRecorder {
 public:
  // Makes the folder. Its first frame gets the stamp `begun_ns` (since 1970), so that it is known
  // of what day the recording is; later ones follow by the device's clock. Fails where the camera
  // is not calibrated or has no depth: nothing could be mapped.
  [[nodiscard]] static Expected<std::shared_ptr<WalkRecorder>> begin(
      const std::filesystem::path& folder, const service::DeviceCamera& camera,
      TimestampNs begun_ns);

  // Stores a frame before it returns, as the hello's camera takes it (images_of()) and with what
  // the device knew of its motion. Frames without depth are counted alone: nothing could be mapped
  // by them. Where the device's clock does not go forward (it stands, was set, or began anew, as
  // that of a page which is loaded again), the time that passed between the frames here counts.
  // False where the recording is closed. Fails on pictures that cannot be read and on a full disk;
  // the frame is then not stored, the ones before it are.
  [[nodiscard]] Expected<bool> store(const CameraFrame& frame);
  // What is stored from now on shows this room.
  [[nodiscard]] Expected<void> name_room(const std::string& room);
  [[nodiscard]] Expected<void> close();  // one that failed can be tried again

  [[nodiscard]] std::uint64_t frames() const;         // that were stored
  [[nodiscard]] std::uint64_t without_depth() const;  // those that were not
  // Waits until the frame of that number is stored. False where none will be: the recording is
  // closed, or `interruption` says so, which is asked ten times a second.
  [[nodiscard]] bool wait_for_frame(std::uint64_t index, const Interruption& interruption) const;
  [[nodiscard]] const geometry::PinholeCamera& camera() const { return camera_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] std::string name() const { return folder_.filename().string(); }

 private:
  WalkRecorder(std::filesystem::path folder, geometry::PinholeCamera camera,
               std::unique_ptr<recording::TumWriter> writer, TimestampNs begun_ns)
      : folder_(std::move(folder)),
        camera_(camera),
        writer_(std::move(writer)),
        begun_ns_(begun_ns) {}

  std::filesystem::path folder_;
  geometry::PinholeCamera camera_;
  mutable std::mutex mutex_;
  mutable std::condition_variable grown_;  // or closed
  std::unique_ptr<recording::TumWriter> writer_;
  TimestampNs begun_ns_ = 0;
  // By the device's clock; first_t_ms_ is moved where that does not go forward.
  std::optional<double> first_t_ms_, last_t_ms_;
  std::chrono::steady_clock::time_point last_came_;
  std::uint64_t without_depth_ = 0;
  bool closed_ = false;
};

}  // namespace roomwise::live
