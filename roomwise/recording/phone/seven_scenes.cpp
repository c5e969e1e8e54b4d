#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/phone/folders.h"
#include "roomwise/recording/phone/json_file.h"
#include "roomwise/recording/phone/numbered_files.h"
#include "roomwise/recording/phone/phone_recording.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::uint16_t kNoDepth = 65535;
constexpr TimestampNs kFrame_ns = 33'333'333;
constexpr std::uint64_t kMaxFrames = 1'000'000'000;

geometry::PinholeCamera kinect(double focal_px) {
  return {focal_px, focal_px, 320, 240, 640, 480, {}, 1000};
}

// Four rows of four numbers, camera to world, x right, y down, z forward.
Expected<geometry::RigidTransform> read_scene_pose(const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<double> rows;
  for (const DataLine& line : data_lines(text)) {
    for (const std::string_view word : line.words) {
      const auto number = parse_number<double>(word);
      if (!number) return fail("{}:{}: '{}' is no number", file.string(), line.number, word);
      rows.push_back(*number);
    }
  }
  if (rows.size() != 16) return fail("{}: has {} numbers, expected 16", file.string(), rows.size());
  return in_context(file.string(), pose_of_rows(rows));
}

}  // namespace

bool is_seven_scenes_folder(const fs::path& folder) {
  return (has_numbered_file(folder, "frame-", ".color.png") ||
          has_numbered_file(folder, "frame-", ".color.jpg")) &&
         has_numbered_file(folder, "frame-", ".depth.png") &&
         !fs::exists(folder / "info.txt");  // BundleFusion's, of a camera that it tells
}

Expected<std::unique_ptr<Recording>> open_seven_scenes_folder(const fs::path& folder,
                                                              const RecordingOptions& options) {
  ROOMWISE_TRY(auto colors, numbered_files(folder, "frame-", ".color.png"));
  ROOMWISE_TRY(auto packed_colors, numbered_files(folder, "frame-", ".color.jpg"));
  colors.merge(packed_colors);
  ROOMWISE_TRY(const auto depths, numbered_files(folder, "frame-", ".depth.png"));
  ROOMWISE_TRY(const auto poses, numbered_files(folder, "frame-", ".pose.txt"));
  PhoneListing listing{"7-Scenes", recording_name(folder), {}, {}};
  listing.no_depth = kNoDepth;
  listing.depth_camera = kinect(585);
  for (const auto& [number, color] : colors) {
    if (number > kMaxFrames) return fail("{}: its number is too large", color.string());
    const auto timestamp_ns = static_cast<TimestampNs>(number) * kFrame_ns;
    const fs::path file = file_or_none(poses, number);
    if (!file.empty()) {
      const auto world_from_camera = read_scene_pose(file);
      if (!world_from_camera) {
        listing.damaged.push_back({number, world_from_camera.error().message});
        continue;
      }
      listing.device_poses.push_back({timestamp_ns, *world_from_camera});
    }
    listing.pictures.push_back(
        {number, timestamp_ns, color, file_or_none(depths, number), kinect(525)});
  }
  return PhoneRecording::open(std::move(listing), options);
}

}  // namespace roomwise::recording
