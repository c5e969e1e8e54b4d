#include "roomwise/recording/recording.h"

#include <algorithm>

#include "roomwise/image/codec.h"

namespace roomwise::recording {

Expected<void> RecordingOptions::validate() const {
  if (tolerance_ns <= 0) return fail("tolerance_ns = {} must be positive", tolerance_ns);
  if (camera) ROOMWISE_CHECK_OK(camera->validate());
  return {};
}

Recording::Recording(RecordingContents contents) : contents_(std::move(contents)) {
  for (const RecordedPicture& picture : contents_.pictures) {
    if (picture.has_depth) frames_.push_back(picture.index);
  }
  count_what_is_left();
}

void Recording::count_what_is_left() {
  contents_.info.frame_count = frames_.size() - position_;
}

const RecordedPicture* Recording::find(std::uint64_t index) const {
  const auto picture = std::ranges::lower_bound(pictures(), index, {}, &RecordedPicture::index);
  return picture != pictures().end() && picture->index == index ? &*picture : nullptr;
}

Expected<std::optional<image::RgbdFrame>> Recording::next() {
  if (position_ == frames_.size()) return std::optional<image::RgbdFrame>();
  const std::uint64_t index = frames_[position_++];
  count_what_is_left();
  return frame(index);
}

void Recording::skip_before(std::uint64_t index) {
  while (position_ < frames_.size() && frames_[position_] < index) ++position_;
  count_what_is_left();
}

Expected<std::optional<image::RgbdFrame>> Recording::frame(std::uint64_t index) const {
  const RecordedPicture* picture = find(index);
  if (picture == nullptr || !picture->has_depth) return std::optional<image::RgbdFrame>();
  return read_frame(*picture);
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

std::string recording_name(const std::filesystem::path& path) {
  const auto folder = (std::filesystem::absolute(path) / "").lexically_normal();
  return folder.parent_path().filename().string();
}

}  // namespace roomwise::recording
