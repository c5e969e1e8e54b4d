#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// What a phone's LiDAR measured between two pictures.
struct PhoneDepthView {
  TimestampNs timestamp_ns = 0;
  std::filesystem::path depth;                 // 16-bit PNG, mm
  geometry::PinholeCamera camera;              // of a picture then; its size may be absent
  geometry::RigidTransform picture_from_view;  // from the picture before it
};

// A picture of a phone and what its LiDAR measured at the same moment.
struct PhonePicture {
  std::uint64_t index = 0;
  TimestampNs timestamp_ns = 0;
  std::filesystem::path color;                   // JPEG or PNG
  std::filesystem::path depth;                   // 16-bit PNG, mm; empty where there is none
  geometry::PinholeCamera camera;                // its size may be absent: that of the picture
  std::size_t place = 0;                         // in its file, where that holds more than one
  std::vector<PhoneDepthView> depth_views = {};  // before the next picture
};

// What the files of a phone's recording say.
struct PhoneListing {
  std::string kind;  // for people: "Stray Scanner"
  std::string name;
  std::vector<PhonePicture> pictures;
  Trajectory device_poses;
  std::vector<DamagedFrame> damaged = {};  // in the order of their indices
  std::vector<std::string> notes = {};     // see RecordingContents
  image::PersonalData personal_data = {};  // of all but the pictures
  bool poses_are_device_motion = false;    // known while it recorded, not reconstructed later
  // Up in the device's world, unit length.
  std::optional<Eigen::Vector3d> device_up = std::nullopt;
  // What a depth image has where nothing was measured, besides 0.
  std::uint16_t no_depth = 0;
  // Of the depth images, where it does not follow from that of the pictures.
  std::optional<geometry::PinholeCamera> depth_camera = {};
  // Reads a picture by its place where its file holds more than one; empty: each is a file of its
  // own.
  // Called from several threads at once.
  std::function<Expected<image::ColorImage>(std::size_t place)> read_color = {};
};

// A recording of a phone: pictures, each with a camera of its own, and smaller depth images, as
// files. Its frames are as if one camera had taken them all (one_camera.h), with at most 640 px a
// side, turned upright where the poses know where up is (quarter_turn.h); depth is in mm. All depth
// counts, whatever confidence the phone has in it: without that of the lowest, which is the far end
// of a corridor, maps get worse.
class PhoneRecording final : public Recording {
 public:
  // Fails where there is no picture with depth, where no picture can be read and where `options`
  // ask for another camera. Pictures whose time does not increase with the longest run of the
  // others, or whose camera cannot be, count as damaged.
  [[nodiscard]] static Expected<std::unique_ptr<Recording>> open(PhoneListing listing,
                                                                 const RecordingOptions& options);
  [[nodiscard]] geometry::PinholeCamera original_camera(
      const RecordedPicture& picture) const override;
  [[nodiscard]] std::string describe(const RecordedPicture& picture) const override;

 private:
  PhoneRecording(RecordingContents contents, PhoneListing listing,
                 const geometry::PinholeCamera& common_camera, int turns)
      : Recording(std::move(contents)),
        listing_(std::move(listing)),
        common_camera_(common_camera),
        turns_(turns) {}
  [[nodiscard]] const PhonePicture& original(const RecordedPicture& picture) const;
  [[nodiscard]] Expected<Bytes> read_encoded(const PhonePicture& picture) const;
  [[nodiscard]] Expected<image::DepthImage> read_depth(const std::filesystem::path& file,
                                                       const geometry::PinholeCamera& camera) const;
  [[nodiscard]] std::vector<image::DepthView> read_depth_views(const PhonePicture& picture) const;
  [[nodiscard]] Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const override;
  [[nodiscard]] Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const override;
  [[nodiscard]] Expected<Bytes> read_picture_file(const RecordedPicture& picture) const override;

  PhoneListing listing_;
  geometry::PinholeCamera common_camera_;  // before pictures are turned
  int turns_;                              // of each, to the right (quarter_turn.h)
};

}  // namespace roomwise::recording
