#include "roomwise/pipeline/stored/mapper_storage.h"

#include <algorithm>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/mapping/frontend/device_odometry.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"
#include "roomwise/pipeline/stored/stored_keyframes.h"

namespace roomwise::pipeline {
namespace {

// A commit waits for the disk: where no key-frame is made, so many frames share one.
constexpr std::uint64_t kFramesACommit = 30;

// Not those where the device's own motion, by which they are placed, jumped.
std::vector<image::DepthView> depth_views_of(const image::RgbdFrame& frame) {
  std::vector<image::DepthView> views = frame.depth_views;
  std::erase_if(views, [&](const image::DepthView& view) {
    return mapping::is_device_jump(view.frame_from_view,
                                   seconds_between(frame.timestamp_ns, view.timestamp_ns));
  });
  return views;
}

}  // namespace

home::KeyframeImages images_of(const image::RgbdFrame& frame) {
  return {image::color_file(frame), image::depth_file(frame)};
}

home::KeyframeId first_keyframe_of(std::span<const home::Keyframe> keyframes,
                                   home::RecordingId recording) {
  const auto first = std::ranges::find(keyframes, recording, &home::Keyframe::recording);
  return static_cast<home::KeyframeId>(first - keyframes.begin());
}

Expected<void> restore_mapper(mapping::Mapper& mapper, const home::Home& home,
                              home::RecordingId recording,
                              const features::FeatureExtractor& extractor,
                              const MapSettings& settings, RunContext& run,
                              std::optional<KnownAppearances> known) {
  ROOMWISE_TRY(const auto stored, home.keyframes());
  const auto take = [&](mapping::Keyframe keyframe) {
    return mapper.restore_keyframe(std::move(keyframe));
  };
  const home::KeyframeId first = first_keyframe_of(stored, recording);
  // The index hashes about the first key-frame.
  const bool is_known = known && !known->keyframes.empty() && known->keyframes.front() == 0 &&
                        known->keyframes.back() < first;
  if (is_known) {
    known->index.renumber(known->keyframes);
    std::vector<home::Keyframe> unknown;
    std::ranges::copy_if(std::span(stored).first(first), std::back_inserter(unknown),
                         [&](const home::Keyframe& one) {
                           return !std::ranges::binary_search(known->keyframes, one.id);
                         });
    const auto index = [&](const mapping::Keyframe& keyframe) -> Expected<void> {
      known->index.add(keyframe.id, keyframe.measurements.features().features);
      return {};
    };
    ROOMWISE_RETURN_IF_ERROR(measure_each_keyframe(home, unknown, extractor, settings, run, index));
    ROOMWISE_TRY(const auto cameras, recording_cameras(home));
    mapper.restore_stored(
        {stored.begin(), stored.begin() + static_cast<std::ptrdiff_t>(first)},
        std::move(known->index),
        [&home, &extractor, settings, cameras, stored,
         lost = run.lost](home::KeyframeId id) -> Expected<motion::FrameMeasurements> {
          const geometry::PinholeCamera& camera = cameras.at(stored[id].recording);
          auto decoded = home.images(id).and_then(
              [&](const home::KeyframeImages& images) { return decode(images, camera); });
          if (!decoded) {
            ROOMWISE_RETURN_IF_ERROR(go_on_without(home, id, std::move(decoded).error(), lost));
            decoded = blank(camera);
          }
          return measure_frame(decoded->color, decoded->depth, camera, extractor, settings);
        });
  }
  const auto rest = std::span(stored).subspan(is_known ? first : 0);
  ROOMWISE_RETURN_IF_ERROR(measure_each_keyframe(home, rest, extractor, settings, run, take));
  ROOMWISE_TRY(const auto edges, home.edges());
  ROOMWISE_TRY(const auto frames, home.frames(recording));
  mapper.restore(edges, frames, first);
  return {};
}

MapWriter::MapWriter(home::Home& home, home::RecordingId recording, mapping::Mapper& mapper)
    : home_(home),
      recording_(recording),
      mapper_(mapper),
      first_keyframe_(0),
      edges_written_(mapper.edges().size()),
      frames_written_(mapper.frame_count()) {}

Expected<MapWriter> MapWriter::create(home::Home& home, home::RecordingId recording,
                                      mapping::Mapper& mapper) {
  MapWriter writer(home, recording, mapper);
  ROOMWISE_TRY(const auto stored, home.keyframes());
  writer.first_keyframe_ = first_keyframe_of(stored, recording);
  for (const home::Keyframe& keyframe : stored) writer.poses_.push_back(keyframe.pose);
  mapper.release_frames(0);
  return writer;
}

Expected<void> MapWriter::write(
    const mapping::MapUpdate& step,
    const std::function<const image::RgbdFrame&(std::uint64_t)>& frame_of) {
  const std::uint64_t waiting = mapper_.frame_count() - frames_written_;
  if (step.new_keyframes.empty() && (!step.is_checkpoint || waiting < kFramesACommit)) return {};
  std::vector<home::NewKeyframe> keyframes;
  for (const mapping::KeyframeId id : step.new_keyframes) {
    const mapping::KeyframeStamp& keyframe = mapper_.keyframes()[id];
    poses_.push_back(first_pose(id));
    const image::RgbdFrame& frame = frame_of(keyframe.frame_index);
    home::NewKeyframe& stored = keyframes.emplace_back(
        home::NewKeyframe{keyframe, poses_.back(), images_of(frame), {}, {}});
    if (mapper_.uses_device_motion()) stored.depth_views = depth_views_of(frame);
  }
  const std::uint64_t newest =
      step.is_checkpoint ? mapper_.frames().back().index : keyframes.back().frame_index;
  return commit(std::move(keyframes), newest + 1);
}

Expected<void> MapWriter::write_rest() {
  if (mapper_.frames().empty()) return commit({}, 0);
  return commit({}, mapper_.frames().back().index + 1);
}

Expected<void> MapWriter::commit(std::vector<home::NewKeyframe> keyframes,
                                 std::uint64_t next_frame_index) {
  home::MapCommit step;
  step.recording = recording_;
  step.keyframes = std::move(keyframes);
  step.next_frame_index = next_frame_index;
  for (; edges_written_ < mapper_.edges().size(); ++edges_written_) {
    step.edges.push_back(mapper_.edges()[edges_written_]);
  }
  const std::uint64_t first = mapper_.frame_count() - mapper_.frames().size();
  for (; frames_written_ < mapper_.frame_count(); ++frames_written_) {
    const scene::Frame& frame = mapper_.frames()[frames_written_ - first];
    if (frame.index >= next_frame_index) break;
    step.frames.push_back(frame);
  }
  mapper_.release_frames(mapper_.frame_count() - frames_written_);
  return home_.commit(step);
}

home::KeyframePose MapWriter::first_pose(mapping::KeyframeId id) const {
  for (std::size_t i = edges_written_; i < mapper_.edges().size(); ++i) {
    const mapping::PoseGraphEdge& edge = mapper_.edges()[i];
    if (edge.to != id || edge.from < first_keyframe_) continue;
    return {poses_[edge.from].world_from_keyframe * edge.from_from_to, poses_[edge.from].component};
  }
  std::uint64_t components = 0;
  for (const home::KeyframePose& pose : poses_)
    components = std::max(components, pose.component + 1);
  return {geometry::RigidTransform::identity(), components};
}

}  // namespace roomwise::pipeline
