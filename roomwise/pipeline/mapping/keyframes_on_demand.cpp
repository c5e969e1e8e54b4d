#include "roomwise/pipeline/mapping/keyframes_on_demand.h"

#include <utility>

#include "roomwise/motion/measurement_bytes.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"

namespace roomwise::pipeline {

KeyframesOnDemand::KeyframesOnDemand(home::Home reader, std::vector<home::Keyframe> keyframes,
                                     MapSettings settings, std::size_t max_bytes,
                                     std::shared_ptr<LostPictures> lost)
    : reader_(std::move(reader)),
      keyframes_(std::move(keyframes)),
      settings_(std::move(settings)),
      max_bytes_(max_bytes),
      lost_(std::move(lost)),
      extractor_(features::make_extractor(settings_.features, settings_.max_keypoints)) {}

Expected<std::shared_ptr<KeyframesOnDemand>> KeyframesOnDemand::create(
    const home::Home& home, std::vector<home::Keyframe> keyframes, MapSettings settings,
    std::size_t max_bytes, std::shared_ptr<LostPictures> lost) {
  ROOMWISE_TRY(home::Home reader, home.another_reader());
  const std::shared_ptr<KeyframesOnDemand> made(new KeyframesOnDemand(
      std::move(reader), std::move(keyframes), std::move(settings), max_bytes, std::move(lost)));
  ROOMWISE_TRY(made->cameras_, recording_cameras(home));
  if (!made->keyframes_.empty()) {
    const home::KeyframeId first = made->keyframes_.front().id;
    const auto is_read = made->read(made->keyframes_.front());
    if (!is_read)
      ROOMWISE_RETURN_IF_ERROR(go_on_without(home, first, is_read.error(), made->lost_));
  }
  return made;
}

Expected<std::optional<home::KeyframeImages>> KeyframesOnDemand::read(
    const home::Keyframe& keyframe) {
  const std::scoped_lock lock(reader_mutex_);
  ROOMWISE_TRY(const auto now, reader_.find_keyframe(keyframe.id));
  if (!now) return std::nullopt;
  ROOMWISE_TRY(home::KeyframeImages images, reader_.images(keyframe.id));
  // Where a walk was taken out meanwhile, key-frames were numbered anew: it is another one's then.
  ROOMWISE_TRY(const auto still, reader_.find_keyframe(keyframe.id));
  for (const auto& held : {now, still}) {
    if (!held || held->recording != keyframe.recording ||
        held->frame_index != keyframe.frame_index || held->timestamp_ns != keyframe.timestamp_ns) {
      return std::nullopt;
    }
  }
  return images;
}

Expected<std::optional<motion::FrameMeasurements>> KeyframesOnDemand::measure(std::size_t index) {
  const home::Keyframe& keyframe = keyframes_[index];
  ROOMWISE_TRY(const auto images, read(keyframe));
  if (!images) return std::nullopt;
  const geometry::PinholeCamera& camera = cameras_.at(keyframe.recording);
  ROOMWISE_TRY(const DecodedImages decoded, decode(*images, camera));
  return measure_frame(decoded.color, decoded.depth, camera, *extractor_, settings_);
}

std::shared_ptr<const mapping::MeasuredKeyframe> KeyframesOnDemand::get(std::size_t index) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto held = held_.find(index); held != held_.end()) {
      used_.splice(used_.begin(), used_, held->second.use);
      return held->second.keyframe;
    }
  }
  // Without the lock: what two threads measure at once is the same.
  auto measured = measure(index);
  if (measured) return *measured ? put(index, **std::move(measured)) : nullptr;
  auto go_on = go_on_without(reader_, keyframes_[index].id, std::move(measured).error(), lost_);
  if (go_on) return nullptr;
  const std::scoped_lock lock(mutex_);
  if (!failure_) failure_ = std::move(go_on).error();
  return nullptr;
}

std::shared_ptr<const mapping::MeasuredKeyframe> KeyframesOnDemand::put(
    std::size_t index, motion::FrameMeasurements measurements) {
  auto keyframe = std::make_shared<const mapping::MeasuredKeyframe>(
      mapping::MeasuredKeyframe::of(std::move(measurements)));
  const std::size_t bytes =
      motion::memory_bytes(keyframe->measurements) + keyframe->pattern.even.pixels().size_bytes();
  const std::scoped_lock lock(mutex_);
  if (held_.contains(index)) return keyframe;
  used_.push_front(index);
  held_[index] = {keyframe, bytes, used_.begin()};
  bytes_ += bytes;
  while (bytes_ > max_bytes_ && used_.size() > 1) {
    const auto oldest = held_.find(used_.back());
    bytes_ -= oldest->second.bytes;
    held_.erase(oldest);
    used_.pop_back();
  }
  return keyframe;
}

std::optional<Error> KeyframesOnDemand::take_failure() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(failure_, std::nullopt);
}

}  // namespace roomwise::pipeline
