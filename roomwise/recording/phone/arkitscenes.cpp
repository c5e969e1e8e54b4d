#include <algorithm>
#include <map>

#include "roomwise/base/file.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/phone/folders.h"
#include "roomwise/recording/phone/phone_recording.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrajectory = "lowres_wide.traj";

using TimedFiles = std::map<TimestampNs, fs::path>;

// Those of a folder whose names end in "_SECONDS.ENDING".
Expected<TimedFiles> timed_files(const fs::path& folder, std::string_view ending) {
  TimedFiles files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::size_t underscore = name.rfind('_');
    if (!name.ends_with(ending) || underscore == std::string::npos) continue;
    if (underscore + 1 + ending.size() > name.size()) continue;
    const auto time =
        parse_timestamp(name.substr(underscore + 1, name.size() - underscore - 1 - ending.size()));
    if (time) files.emplace(*time, entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  return files;
}

// One line "width height fx fy cx cy".
Expected<geometry::PinholeCamera> read_pincam(const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  const auto lines = data_lines(text);
  if (lines.size() != 1 || lines[0].words.size() != 6) {
    return fail("{}: expected one line: width height fx fy cx cy", file.string());
  }
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_number<double>(lines[0].words[i]);
    if (!value || std::abs(*value) > 1e5) {
      return fail("{}: '{}' is no such number", file.string(), lines[0].words[i]);
    }
    values[i] = *value;
  }
  geometry::PinholeCamera camera;
  camera.width = static_cast<int>(values[0]);
  camera.height = static_cast<int>(values[1]);
  camera.fx = values[2];
  camera.fy = values[3];
  camera.cx = values[4];
  camera.cy = values[5];
  return camera;
}

// A line a pose: time, rotation vector, translation (m) of world to camera.
Expected<StampedPose> parse_traj_line(const DataLine& line) {
  if (line.words.size() != 7) return fail("{} values, expected 7", line.words.size());
  StampedPose pose;
  ROOMWISE_TRY(pose.timestamp_ns, parse_timestamp(line.words[0]));
  Eigen::Matrix<double, 6, 1> values;
  for (int i = 0; i < 6; ++i) {
    const auto word = line.words[static_cast<std::size_t>(i) + 1];
    const auto value = parse_number<double>(word);
    if (!value || std::abs(*value) > 1e6) return fail("'{}' is no such number", word);
    values[i] = *value;
  }
  const double angle_rad = values.head<3>().norm();
  const Eigen::Vector3d axis =
      angle_rad > 0 ? (values.head<3>() / angle_rad).eval() : Eigen::Vector3d::UnitX();
  const geometry::RigidTransform camera_from_world{
      Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis)), values.tail<3>()};
  pose.world_from_camera = camera_from_world.inverse();
  return pose;
}

Expected<Trajectory> read_traj(const fs::path& file, std::vector<std::string>& notes) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  Trajectory trajectory;
  for (const DataLine& line : data_lines(text)) {
    if (!line.complete) {  // and so may be its last number
      notes.push_back(fmt::format("{}:{}: the file ends within this line; it is left out",
                                  file.string(), line.number));
      break;
    }
    auto pose = parse_traj_line(line);
    const std::string place = fmt::format("{}:{}", file.string(), line.number);
    if (!pose) return Unexpected(std::move(pose).error().with_context(place));
    if (!trajectory.empty() && pose->timestamp_ns <= trajectory.back().timestamp_ns) {
      return fail("{}: its time is not after that of the line before", place);
    }
    trajectory.push_back(*pose);
  }
  return trajectory;
}

// The file taken nearest in time; none where that is farther away than names are rounded.
fs::path nearest(const TimedFiles& files, TimestampNs time) {
  constexpr TimestampNs kRounding_ns = 5'000'000;
  const auto after = files.lower_bound(time - kRounding_ns);
  fs::path best;
  TimestampNs apart = kRounding_ns + 1;
  for (auto file = after; file != files.end() && file->first <= time + kRounding_ns; ++file) {
    if (std::abs(file->first - time) >= apart) continue;
    apart = std::abs(file->first - time);
    best = file->second;
  }
  return best;
}

// The folder of the largest pictures that have intrinsics beside them; empty where none have.
std::string pictures_of(const fs::path& folder) {
  std::error_code ignored;
  for (const std::string which : {"vga_wide", "lowres_wide"}) {
    if (fs::is_directory(folder / which, ignored) &&
        fs::is_directory(folder / (which + "_intrinsics"), ignored)) {
      return which;
    }
  }
  return "";
}

}  // namespace

bool is_arkitscenes_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / "lowres_depth", ignored) && !pictures_of(folder).empty();
}

Expected<std::unique_ptr<Recording>> open_arkitscenes_folder(const fs::path& folder,
                                                             const RecordingOptions& options) {
  std::error_code ignored;
  const std::string which = pictures_of(folder);
  ROOMWISE_TRY(const auto colors, timed_files(folder / which, ".png"));
  ROOMWISE_TRY(const auto cameras, timed_files(folder / (which + "_intrinsics"), ".pincam"));
  ROOMWISE_TRY(const auto depths, timed_files(folder / "lowres_depth", ".png"));
  PhoneListing listing{"ARKitScenes", recording_name(folder), {}, {}};
  listing.poses_are_device_motion = true;  // ARKit's
  for (const auto& [time, color] : colors) {
    const fs::path pincam = nearest(cameras, time);
    const auto camera = pincam.empty() ? fail("{}: has no .pincam of its time in {}_intrinsics",
                                              color.string(), which)
                                       : read_pincam(pincam);
    const std::uint64_t index = listing.pictures.size() + listing.damaged.size();
    if (camera) {
      listing.pictures.push_back({index, time, color, nearest(depths, time), *camera});
    } else {
      listing.damaged.push_back({index, camera.error().message});
    }
  }
  if (fs::exists(folder / kTrajectory, ignored)) {
    ROOMWISE_TRY(listing.device_poses, read_traj(folder / kTrajectory, listing.notes));
  }
  return PhoneRecording::open(std::move(listing), options);
}

}  // namespace roomwise::recording
