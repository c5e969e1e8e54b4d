#include <algorithm>

#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/folders.h"
#include "roomwise/recording/phone/json_file.h"
#include "roomwise/recording/phone/numbered_files.h"
#include "roomwise/recording/phone/phone_recording.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

Expected<int> side_px(const nlohmann::json& json, const char* key) {
  constexpr double kMaxSide_px = 16'384;
  ROOMWISE_TRY(const double side, number_of(json, key));
  if (!(side >= 1 && side <= kMaxSide_px))
    return fail("'{}' = {} is no side of a picture", key, side);
  return static_cast<int>(side);
}

// The time stands in the name alone.
Expected<FrameFacts> polycam_facts(const nlohmann::json& json) {
  FrameFacts facts;
  ROOMWISE_TRY(facts.camera.fx, number_of(json, "fx"));
  ROOMWISE_TRY(facts.camera.fy, number_of(json, "fy"));
  ROOMWISE_TRY(facts.camera.cx, number_of(json, "cx"));
  ROOMWISE_TRY(facts.camera.cy, number_of(json, "cy"));
  ROOMWISE_TRY(facts.camera.width, side_px(json, "width"));
  ROOMWISE_TRY(facts.camera.height, side_px(json, "height"));
  std::vector<double> rows;
  for (const char* key : {"t_00", "t_01", "t_02", "t_03", "t_10", "t_11", "t_12", "t_13", "t_20",
                          "t_21", "t_22", "t_23"}) {
    ROOMWISE_TRY(const double value, number_of(json, key));
    rows.push_back(value);
  }
  ROOMWISE_TRY(facts.world_from_camera, pose_of_arkit(rows));
  return facts;
}

}  // namespace

bool is_polycam_folder(const fs::path& folder) {
  const fs::path frames = folder / "keyframes";
  return has_numbered_file(frames / "cameras", "", ".json") ||
         has_numbered_file(frames / "corrected_cameras", "", ".json");
}

Expected<std::unique_ptr<Recording>> open_polycam_folder(const fs::path& folder,
                                                         const RecordingOptions& options) {
  const fs::path frames = folder / "keyframes";
  const bool is_corrected = has_numbered_file(frames / "corrected_cameras", "", ".json") &&
                            has_numbered_file(frames / "corrected_images", "", ".jpg");
  const std::string which = is_corrected ? "corrected_" : "";
  ROOMWISE_TRY(const auto cameras, numbered_files(frames / (which + "cameras"), "", ".json"));
  ROOMWISE_TRY(const auto images, numbered_files(frames / (which + "images"), "", ".jpg"));
  ROOMWISE_TRY(const auto depths, numbered_files(frames / "depth", "", ".png"));
  PhoneListing listing{"Polycam, raw data", recording_name(folder), {}, {}};
  listing.device_up = kArkitUp;
  // Corrected ones were adjusted to the pictures afterwards.
  listing.poses_are_device_motion = !is_corrected;
  for (const auto& [microseconds, image] : images) {
    constexpr std::uint64_t kLatest = 1ULL << 53U;
    if (microseconds > kLatest) return fail("{}: its name is no time", image.string());
    const fs::path camera = file_or_none(cameras, microseconds);
    const auto facts = camera.empty()
                           ? fail("{}: has no camera of its name in {}; copy the recording again",
                                  image.string(), (frames / (which + "cameras")).string())
                           : read_frame_facts(camera, polycam_facts);
    const std::uint64_t index = listing.pictures.size() + listing.damaged.size();
    if (!facts) {
      listing.damaged.push_back({index, facts.error().message});
      continue;
    }
    const auto timestamp_ns = static_cast<TimestampNs>(microseconds * 1000);
    listing.pictures.push_back(
        {index, timestamp_ns, image, file_or_none(depths, microseconds), facts->camera});
    listing.device_poses.push_back({timestamp_ns, facts->world_from_camera});
    listing.personal_data |= facts->personal;
  }
  listing.personal_data |= personal_data_of_json_file(folder / "mesh_info.json");
  const auto lost = std::ranges::count_if(
      cameras, [&](const auto& camera) { return !images.contains(camera.first); });
  if (lost > 0) {
    listing.notes.push_back(
        fmt::format("{} of {} cameras have no picture; were all copied?", lost, cameras.size()));
  }
  return PhoneRecording::open(std::move(listing), options);
}

}  // namespace roomwise::recording
