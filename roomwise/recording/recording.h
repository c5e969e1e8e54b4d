#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/geometry/inertial_track.h"
#include "roomwise/recording/frame_source.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::recording {

// A colour image of a recording.
struct RecordedPicture {
  std::uint64_t index = 0;  // RgbdFrame::index of its frame
  TimestampNs timestamp_ns = 0;
  bool has_depth = false;  // with depth it is a frame
};

// A frame of which something besides its picture is missing or damaged: a file beside it, its line.
struct DamagedFrame {
  std::uint64_t index = 0;
  std::string why;  // names the file
};

struct RecordingOptions {
  // Replaces what the recording says of its camera; a kind whose camera cannot be another refuses
  // it.
  std::optional<geometry::PinholeCamera> camera;
  // A colour and a depth image less than this apart (ns) make a frame, where they are matched by
  // time.
  TimestampNs tolerance_ns = 20'000'000;

  [[nodiscard]] Expected<void> validate() const;
};

// What opening a recording finds out before any picture is read.
struct RecordingContents {
  std::string kind;                       // for people: "TUM folder"
  SourceInfo info;                        // frames_remaining is counted from `pictures`
  std::vector<RecordedPicture> pictures;  // index and time both strictly increasing
  std::vector<DamagedFrame> damaged;      // not among `pictures`
  // Where the device says that it was: camera to world, x right, y down, z forward in the camera,
  // the world as the device had it. Empty where it wrote none.
  Trajectory device_poses;
  // Whether the device knew these poses while it recorded, so that mapping may take them for its
  // motion; not where they were reconstructed from the pictures afterwards.
  bool poses_are_device_motion = false;
  // The direction up in the device's world, unit length, where that is level.
  std::optional<Eigen::Vector3d> device_up = std::nullopt;
  // What an inertial sensor felt, raw, where the device wrote that.
  geometry::InertialTrack inertial = {};
  // For people: what was chosen among several, what was found wrong and passed over, what an end
  // that was cut off lacks.
  std::vector<std::string> notes;
  // Whether a frame is read much quicker right after the one before it: of a video.
  bool reads_in_order = false;
};

// A recording that is complete on the disk, of any kind: its frames in the order of time, and each
// picture by its index.
class Recording : public FrameSource {
 public:
  [[nodiscard]] const SourceInfo& info() const final { return contents_.info; }
  [[nodiscard]] const std::string& kind() const { return contents_.kind; }
  // All colour images, with depth or without.
  [[nodiscard]] const std::vector<RecordedPicture>& pictures() const { return contents_.pictures; }
  // The indices of those with depth.
  [[nodiscard]] const std::vector<std::uint64_t>& frames() const { return frames_; }
  [[nodiscard]] const std::vector<DamagedFrame>& damaged() const { return contents_.damaged; }
  [[nodiscard]] const Trajectory& device_poses() const { return contents_.device_poses; }
  // Whether frames carry device_poses() as their device_motion.
  [[nodiscard]] bool has_device_motion() const {
    return contents_.poses_are_device_motion && !contents_.device_poses.empty();
  }
  // Of a device that tells no motion; where it does, its poses hold what its sensor felt.
  [[nodiscard]] const geometry::InertialTrack& inertial() const { return contents_.inertial; }
  // For people, a sentence each: what was chosen among several streams, what was passed over.
  [[nodiscard]] const std::vector<std::string>& notes() const { return contents_.notes; }
  // Null where there is no such colour image.
  [[nodiscard]] const RecordedPicture* find(std::uint64_t index) const;

  [[nodiscard]] bool reads_in_order() const { return contents_.reads_in_order; }

  // First fails for each of damaged(), so that nobody works for long before it is known.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() final;
  // The same without reading the frame: its index.
  [[nodiscard]] Expected<std::optional<std::uint64_t>> next_index();
  void skip_before(std::uint64_t index) final;
  // The frame of a colour image, whatever next() has given; nothing where there is none. Fails as
  // next() does. Thread-safe.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> frame(std::uint64_t index) const;
  // A colour image, with depth or without, as it is in its frame. Fails where there is none of that
  // index or it cannot be read. Thread-safe.
  [[nodiscard]] Expected<image::ColorImage> read_color(std::uint64_t index) const;
  // The same as a file: what image::color_file() makes of its frame.
  [[nodiscard]] Expected<Bytes> read_color_file(std::uint64_t index) const;
  // The camera of a picture as its file has it, of its own size: what is told in pixels of the file
  // is to be brought to info().camera, which its frame has.
  [[nodiscard]] virtual geometry::PinholeCamera original_camera(
      const RecordedPicture& picture) const;
  // A colour image as errors and people name it: its file, or the recording and its number.
  [[nodiscard]] virtual std::string describe(const RecordedPicture& picture) const;

 protected:
  explicit Recording(RecordingContents contents);
  // Both are called from several threads at once; errors name the picture's file. The frame has
  // info().camera's size, and the index and time of `picture`, which has depth; read again, it is
  // the same bit for bit. Its encoded images may be absent (RgbdFrame).
  [[nodiscard]] virtual Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const = 0;
  [[nodiscard]] virtual Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const = 0;
  // For kinds that have it at hand: without it, the picture is read and encoded.
  [[nodiscard]] virtual Expected<Bytes> read_picture_file(const RecordedPicture& picture) const;

 private:
  void count_what_is_left();
  void keep_inertial_that_tells();
  // At a picture's time: the device's pose of that time, or between two that are close together.
  [[nodiscard]] std::optional<geometry::DeviceMotion> motion_at(TimestampNs timestamp_ns) const;

  RecordingContents contents_;
  std::vector<std::uint64_t> frames_;
  std::size_t position_ = 0;     // in frames_
  std::size_t damage_told_ = 0;  // of contents_.damaged
};

// The error of a recording that holds no whole frame: it names the first that is damaged.
[[nodiscard]] Unexpected no_whole_frame(std::string_view name,
                                        const std::vector<DamagedFrame>& damaged);

// What is common to opening a folder: its own name, also of "." and "recordings/home/"; of a file,
// its name.
[[nodiscard]] std::string recording_name(const std::filesystem::path& path);

}  // namespace roomwise::recording
