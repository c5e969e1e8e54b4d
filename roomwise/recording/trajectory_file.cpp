#include "roomwise/recording/trajectory_file.h"

#include <array>
#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

constexpr std::string_view kPoseLayout = "timestamp tx ty tz qx qy qz qw";
constexpr std::array<std::string_view, 7> kPoseNames{"tx", "ty", "tz", "qx", "qy", "qz", "qw"};

Expected<StampedPose> parse_pose(std::span<const std::string_view> words) {
  if (words.size() != kPoseNames.size() + 1) {
    return fail("{} values, expected {}", words.size(), kPoseLayout);
  }
  StampedPose pose;
  ROOMWISE_TRY(pose.timestamp_ns, parse_timestamp(words[0]));
  std::array<double, kPoseNames.size()> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_number<double>(words[i + 1]);
    if (!value) {
      return fail("{} = '{}' is not a finite number; expected {}", kPoseNames[i], words[i + 1],
                  kPoseLayout);
    }
    values[i] = *value;
  }
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  constexpr double kShortest = 1e-6;  // below this the direction is rounding
  if (!std::isfinite(rotation.norm()) || rotation.norm() < kShortest) {
    return fail("the quaternion {} {} {} {} has no usable length", words[4], words[5], words[6],
                words[7]);
  }
  pose.world_from_camera = {rotation.normalized(), {values[0], values[1], values[2]}};
  return pose;
}

}  // namespace

Expected<Trajectory> read_trajectory(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  Trajectory trajectory;
  for (const DataLine& line : data_lines(text)) {
    const std::string place = fmt::format("{}:{}", path.string(), line.number);
    auto pose = parse_pose(line.words);
    // What was written while a device recorded may end in the middle of a line.
    if (!pose && !line.complete && !trajectory.empty()) break;
    if (!pose) return Unexpected(std::move(pose).error().with_context(place));
    if (!trajectory.empty() && pose->timestamp_ns <= trajectory.back().timestamp_ns) {
      return fail("{}: the time {} does not increase; sort the lines by time, each time once",
                  place, line.words[0]);
    }
    trajectory.push_back(*pose);
  }
  if (trajectory.empty()) return fail("{}: holds no pose; expected {}", path.string(), kPoseLayout);
  return trajectory;
}

std::string trajectory_text(std::span<const StampedPose> trajectory) {
  std::string text = fmt::format("# {}\n", kPoseLayout);
  for (const StampedPose& pose : trajectory) text += trajectory_line(pose);
  return text;
}

std::string trajectory_line(const StampedPose& pose) {
  const auto& t = pose.world_from_camera.translation;
  const auto& q = pose.world_from_camera.rotation;
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                     format_timestamp(pose.timestamp_ns), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                     q.w());
}

Expected<void> write_trajectory(const std::filesystem::path& path,
                                std::span<const StampedPose> trajectory) {
  return write_file(path, trajectory_text(trajectory));
}

}  // namespace roomwise::recording
