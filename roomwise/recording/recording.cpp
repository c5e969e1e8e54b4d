#include "roomwise/recording/recording.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "roomwise/image/codec.h"

namespace roomwise::recording {
namespace {

// Within this time a hand moves evenly, or nearly.
constexpr TimestampNs kMaxBetweenPoses_ns = 150'000'000;

geometry::RigidTransform between(const StampedPose& before, const StampedPose& after,
                                 TimestampNs timestamp_ns) {
  const double share = static_cast<double>(timestamp_ns - before.timestamp_ns) /
                       static_cast<double>(after.timestamp_ns - before.timestamp_ns);
  const auto& [a, b] = std::pair(before.world_from_camera, after.world_from_camera);
  return {a.rotation.slerp(share, b.rotation),
          a.translation + share * (b.translation - a.translation)};
}

}  // namespace

Expected<void> RecordingOptions::validate() const {
  if (tolerance_ns <= 0) return fail("tolerance_ns = {} must be positive", tolerance_ns);
  if (camera) ROOMWISE_RETURN_IF_ERROR(camera->validate());
  return {};
}

Recording::Recording(RecordingContents contents) : contents_(std::move(contents)) {
  for (const RecordedPicture& picture : contents_.pictures) {
    if (picture.has_depth) frames_.push_back(picture.index);
  }
  keep_inertial_that_tells();
  count_what_is_left();
}

void Recording::keep_inertial_that_tells() {
  if (contents_.inertial.empty()) return;
  const auto& samples = contents_.inertial.samples();
  const bool is_of_pictures = std::ranges::any_of(pictures(), [&](const RecordedPicture& picture) {
    return picture.timestamp_ns >= samples.front().timestamp_ns &&
           picture.timestamp_ns <= samples.back().timestamp_ns;
  });
  if (!is_of_pictures) {
    contents_.notes.push_back(fmt::format(
        "the inertial sensor's times, {} to {} s, are those of no picture: it is left out; give "
        "both the times of one clock",
        format_timestamp(samples.front().timestamp_ns),
        format_timestamp(samples.back().timestamp_ns)));
  }
  if (!is_of_pictures || has_device_motion()) contents_.inertial = {};
}

void Recording::count_what_is_left() {
  contents_.info.frames_remaining = frames_.size() - position_;
}

const RecordedPicture* Recording::find(std::uint64_t index) const {
  const auto picture = std::ranges::lower_bound(pictures(), index, {}, &RecordedPicture::index);
  return picture != pictures().end() && picture->index == index ? &*picture : nullptr;
}

Expected<std::optional<image::RgbdFrame>> Recording::next() {
  ROOMWISE_TRY(const std::optional<std::uint64_t> index, next_index());
  if (!index) return std::optional<image::RgbdFrame>();
  return frame(*index);
}

Expected<std::optional<std::uint64_t>> Recording::next_index() {
  if (damage_told_ < damaged().size()) return fail("{}", damaged()[damage_told_++].why);
  if (position_ == frames_.size()) return std::optional<std::uint64_t>();
  const std::uint64_t index = frames_[position_++];
  count_what_is_left();
  return std::optional(index);
}

void Recording::skip_before(std::uint64_t index) {
  while (position_ < frames_.size() && frames_[position_] < index) ++position_;
  while (damage_told_ < damaged().size() && damaged()[damage_told_].index < index) ++damage_told_;
  count_what_is_left();
}

Expected<std::optional<image::RgbdFrame>> Recording::frame(std::uint64_t index) const {
  const RecordedPicture* picture = find(index);
  if (picture == nullptr || !picture->has_depth) return std::optional<image::RgbdFrame>();
  ROOMWISE_TRY(image::RgbdFrame read, read_frame(*picture));
  if (contents_.poses_are_device_motion) read.device_motion = motion_at(picture->timestamp_ns);
  return std::optional(std::move(read));
}

std::optional<geometry::DeviceMotion> Recording::motion_at(TimestampNs timestamp_ns) const {
  const Trajectory& poses = contents_.device_poses;
  const auto after = std::ranges::lower_bound(poses, timestamp_ns, {}, &StampedPose::timestamp_ns);
  if (after == poses.end()) return std::nullopt;
  geometry::RigidTransform world_from_camera = after->world_from_camera;
  if (after->timestamp_ns != timestamp_ns) {
    if (after == poses.begin()) return std::nullopt;
    const StampedPose& before = *std::prev(after);
    if (after->timestamp_ns - before.timestamp_ns > kMaxBetweenPoses_ns) return std::nullopt;
    world_from_camera = between(before, *after, timestamp_ns);
  }
  if (!contents_.device_up) return geometry::DeviceMotion{world_from_camera};
  return geometry::DeviceMotion{world_from_camera,
                                world_from_camera.rotation.conjugate() * *contents_.device_up};
}

Expected<image::ColorImage> Recording::read_color(std::uint64_t index) const {
  const RecordedPicture* picture = find(index);
  if (picture == nullptr) return fail("{}: has no picture {}", info().name, index);
  return read_picture(*picture);
}

Expected<Bytes> Recording::read_color_file(std::uint64_t index) const {
  const RecordedPicture* picture = find(index);
  if (picture == nullptr) return fail("{}: has no picture {}", info().name, index);
  return read_picture_file(*picture);
}

Expected<Bytes> Recording::read_picture_file(const RecordedPicture& picture) const {
  if (picture.has_depth) {
    ROOMWISE_TRY(const image::RgbdFrame frame, read_frame(picture));
    return image::color_file(frame);
  }
  ROOMWISE_TRY(const image::ColorImage color, read_picture(picture));
  return image::encode_png(color);
}

geometry::PinholeCamera Recording::original_camera(const RecordedPicture& /*picture*/) const {
  return info().camera;
}

std::string Recording::describe(const RecordedPicture& picture) const {
  return fmt::format("{}: picture {}", info().name, picture.index);
}

Unexpected no_whole_frame(std::string_view name, const std::vector<DamagedFrame>& damaged) {
  if (damaged.empty()) return fail("{}: holds no picture of which all is there", name);
  return fail("{}: none of its {} frames can be read; the first: {}", name, damaged.size(),
              damaged.front().why);
}

std::string recording_name(const std::filesystem::path& path) {
  const auto folder = (std::filesystem::absolute(path) / "").lexically_normal();
  return folder.parent_path().filename().string();
}

}  // namespace roomwise::recording
