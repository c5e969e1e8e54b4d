#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/recording/frame_source.h"
#include "roomwise/recording/odometry_file.h"
#include "roomwise/recording/room_labels.h"

namespace roomwise::recording {

// The frame with its images as TumWriter stores raw ones: JPEG of quality 95 and 16-bit PNG. A
// writer that is given such frames has nothing left to encode.
[[nodiscard]] image::RgbdFrame encode_images(image::RgbdFrame frame);

// Writes a recording that TumRecording reads: rgb/, depth/, rgb.txt, depth.txt, camera.txt and,
// where devices told their motion, odometry.txt; where rooms were named, rooms.txt. Frames are
// numbered from 0 as they come.
//
// A frame's images are written before its lines, and each line in one piece, rgb.txt last: a killed
// recording can be read up to its last whole frame, and so can one that still grows. When the disk
// is full, write() fails, takes back the frame in hand, and what was written before stays valid.
class TumWriter final : public FrameSink {
 public:
  // Makes the folder; one that exists must be empty.
  [[nodiscard]] static Expected<std::unique_ptr<TumWriter>> create(
      const std::filesystem::path& folder, const geometry::PinholeCamera& camera);

  ~TumWriter() override;  // closes; call close() to learn whether that worked
  TumWriter(const TumWriter&) = delete;
  TumWriter& operator=(const TumWriter&) = delete;

  // Stores the frame's encoded images as image::color_file() gives them; raw ones as
  // encode_images() does. Fails where the time does not increase.
  [[nodiscard]] Expected<void> write(const image::RgbdFrame& frame) override {
    return write(frame, std::nullopt);
  }
  // `covariance`: of the frame's device motion; kept behind its pose, for who reads the file.
  [[nodiscard]] Expected<void> write(const image::RgbdFrame& frame,
                                     const std::optional<PoseCovariance>& covariance);
  // One that failed can be tried again.
  [[nodiscard]] Expected<void> close() override;

  // From the next frame on the recording shows `room` (absent: no named room). Each time a room is
  // entered begins its next visit; naming the room that one is in already changes nothing.
  // rooms.txt is brought up to date here, as a visit begins, every few seconds and by close().
  [[nodiscard]] Expected<void> name_room(std::optional<std::string> room);

  [[nodiscard]] std::uint64_t frames_written() const { return frames_; }

 private:
  class List;
  class MotionFile;

  TumWriter(std::filesystem::path folder, const geometry::PinholeCamera& camera);
  [[nodiscard]] Expected<void> check(const image::RgbdFrame& frame) const;
  [[nodiscard]] Expected<void> keep_rooms();
  // Whether a visit begins with it.
  bool note_room_of_next_frame();

  std::filesystem::path folder_;
  geometry::PinholeCamera camera_;
  std::unique_ptr<List> color_list_, depth_list_;  // null once closed
  std::unique_ptr<MotionFile> motion_;             // null until a device told its motion
  std::uint64_t frames_ = 0;
  TimestampNs last_timestamp_ns_ = 0;
  std::optional<std::string> room_;  // that the next frame shows
  std::vector<RoomRange> rooms_;     // of the frames written
  TimestampNs rooms_kept_ns_ = 0;    // the last frame of rooms.txt
};

}  // namespace roomwise::recording
