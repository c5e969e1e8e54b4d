#include "roomwise/recording/phone/scanner_app.h"

#include <algorithm>
#include <map>

#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/json_file.h"
#include "roomwise/recording/phone/longest_rise.h"
#include "roomwise/recording/phone/numbered_files.h"
#include "roomwise/recording/phone/phone_recording.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

// The camera without its size.
Expected<FrameFacts> scanner_app_facts(const nlohmann::json& json) {
  FrameFacts facts;
  ROOMWISE_TRY(const double seconds, number_of(json, "time"));
  ROOMWISE_TRY(facts.timestamp_ns, timestamp_of(seconds));
  ROOMWISE_TRY(const auto camera, numbers_of(json, "intrinsics", 9));
  facts.camera.fx = camera[0];
  facts.camera.cx = camera[2];
  facts.camera.fy = camera[4];
  facts.camera.cy = camera[5];
  ROOMWISE_TRY(const auto pose, numbers_of(json, "cameraPoseARFrame", 16));
  ROOMWISE_TRY(facts.world_from_camera, pose_of_arkit(pose));
  return facts;
}

struct AllFacts {
  std::map<std::uint64_t, FrameFacts> of_frame;
  std::map<std::uint64_t, std::string> damage;  // why there are none
};

// The app writes every frame's file before the next one's, so times that go back are damage.
void leave_out_times_that_go_back(AllFacts& all, const NumberedFiles& files) {
  keep_longest_rise(
      all.of_frame, [](const auto& frame) { return frame.second.timestamp_ns; },
      [&](const auto& frame) {
        const auto& [number, facts] = frame;
        all.damage.emplace(
            number, fmt::format("{}: its time {} s does not fit those of the other frames",
                                files.at(number).string(), format_timestamp(facts.timestamp_ns)));
      });
}

AllFacts read_all_facts(const NumberedFiles& files) {
  AllFacts all;
  for (const auto& [number, file] : files) {
    const auto facts = read_frame_facts(file, scanner_app_facts);
    if (facts) {
      all.of_frame.emplace(number, *facts);
    } else {
      all.damage.emplace(number, facts.error().message);
    }
  }
  leave_out_times_that_go_back(all, files);
  return all;
}

// Of frames without a picture only poses are lost.
void note_lost_poses(const AllFacts& facts, const NumberedFiles& colors, PhoneListing& listing) {
  std::vector<std::string> lost;
  for (const auto& [number, why] : facts.damage) {
    if (!colors.contains(number)) lost.push_back(why);
  }
  if (lost.empty()) return;
  listing.notes.push_back(
      fmt::format("the poses of {} frames without a picture cannot be read; the "
                  "first: {}",
                  lost.size(), lost.front()));
}

// So many are taken between two pictures: where pictures are missing, no frame holds all that
// follows.
constexpr std::size_t kMaxDepthViews = 8;

// The depth images from a picture on until the next one.
std::vector<PhoneDepthView> depth_views_after(std::uint64_t picture, const AllFacts& facts,
                                              const NumberedFiles& colors,
                                              const NumberedFiles& depths) {
  const auto first = facts.of_frame.find(picture);
  const geometry::RigidTransform picture_from_world = first->second.world_from_camera.inverse();
  std::vector<PhoneDepthView> views;
  for (auto at = std::next(first);
       at != facts.of_frame.end() && !colors.contains(at->first) && views.size() < kMaxDepthViews;
       ++at) {
    const auto& [number, of_frame] = *at;
    if (!depths.contains(number)) continue;
    views.push_back({of_frame.timestamp_ns, depths.at(number), of_frame.camera,
                     picture_from_world * of_frame.world_from_camera});
  }
  return views;
}

}  // namespace

bool is_scanner_app_export(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!number_in_name(name, "frame_", ".json")) continue;
    const std::string digits = name.substr(6, name.size() - 11);
    if (fs::exists(folder / ("depth_" + digits + ".png"), error)) return true;
  }
  return false;
}

Expected<std::unique_ptr<Recording>> open_scanner_app_export(const fs::path& folder,
                                                             const RecordingOptions& options) {
  ROOMWISE_TRY(const auto json, numbered_files(folder, "frame_", ".json"));
  ROOMWISE_TRY(const auto colors, numbered_files(folder, "frame_", ".jpg"));
  ROOMWISE_TRY(const auto depths, numbered_files(folder, "depth_", ".png"));
  const AllFacts facts = read_all_facts(json);
  PhoneListing listing{"3D Scanner App, All Data", recording_name(folder), {}, {}};
  listing.poses_are_device_motion = true;  // ARKit's
  listing.device_up = kArkitUp;
  for (const auto& [number, file] : colors) {
    const auto of_frame = facts.of_frame.find(number);
    if (of_frame == facts.of_frame.end()) {
      const auto why = facts.damage.find(number);
      listing.damaged.push_back(
          {number, why != facts.damage.end()
                       ? why->second
                       : fmt::format("{}: has no .json of its number; copy the recording again",
                                     file.string())});
      continue;
    }
    listing.pictures.push_back({number, of_frame->second.timestamp_ns, file,
                                file_or_none(depths, number), of_frame->second.camera, 0,
                                depth_views_after(number, facts, colors, depths)});
  }
  for (const auto& [number, of_frame] : facts.of_frame) {
    listing.device_poses.push_back({of_frame.timestamp_ns, of_frame.world_from_camera});
    listing.personal_data |= of_frame.personal;
  }
  listing.personal_data |= personal_data_of_json_file(folder / "info.json");
  note_lost_poses(facts, colors, listing);
  return PhoneRecording::open(std::move(listing), options);
}

}  // namespace roomwise::recording
