#include "home_pictures.h"

#include <algorithm>
#include <set>

#include "roomwise/image/codec.h"

namespace roomwise::app {

Expected<HomePictures> HomePictures::read(const home::Home& home, const Selects& selects) {
  HomePictures data;
  data.file_ = home.file();
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) return fail("{}: holds no recording; use roomwise map first", data.file_);
  const home::RecordingId recording = recordings.back().id;
  ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording));
  std::set<std::string> rooms;
  for (const recording::RoomRange& range : labels.ranges()) rooms.insert(range.room);
  if (rooms.size() < 2) {
    return fail("{}: has {} named rooms; name two at least with roomwise rooms name", data.file_,
                rooms.size());
  }
  data.rooms_.assign(rooms.begin(), rooms.end());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) {
    if (keyframe.recording != recording) continue;
    const recording::RoomRange* range = labels.find(keyframe.frame_index);
    if (range == nullptr || !selects(*range)) continue;
    ROOMWISE_TRY(home::KeyframeImages images, home.images(keyframe.id));
    const auto room = std::ranges::find(data.rooms_, range->room) - data.rooms_.begin();
    data.pictures_.push_back(
        {keyframe.id, static_cast<std::size_t>(room), std::move(images.color)});
  }
  return data;
}

std::string HomePictures::name(std::size_t i) const {
  return fmt::format("key-frame {}", pictures_[i].keyframe);
}

Expected<image::ColorImage> HomePictures::picture(std::size_t i) const {
  return image::decode_color(pictures_[i].color).map_error([&](Error error) {
    return std::move(error).with_context(fmt::format("{}: {}", file_, name(i)));
  });
}

}  // namespace roomwise::app
