#include "roomwise/pipeline/mapper_storage.h"

#include <algorithm>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/stored_keyframes.h"

namespace roomwise::pipeline {
namespace {

home::Frame stored_frame(const mapping::MappedFrame& frame) {
  home::Frame stored{frame.frame_index, frame.timestamp_ns, std::nullopt, frame.why_unplaced};
  if (frame.place)
    stored.place = home::FramePlace{frame.place->keyframe, frame.place->keyframe_from_camera};
  return stored;
}

// As the camera gave them, else encoded without loss: a resumed run finds its features in them
// again.
home::KeyframeImages images_of(const image::RgbdFrame& frame) {
  return {frame.encoded_color.empty() ? image::encode_png(frame.color) : frame.encoded_color,
          frame.encoded_depth.empty() ? image::encode_png(frame.depth) : frame.encoded_depth};
}

}  // namespace

mapping::MappedFrame mapped_frame(const home::Frame& frame) {
  mapping::MappedFrame mapped{frame.index, frame.timestamp_ns, std::nullopt, frame.no_pose_reason};
  if (frame.place) {
    mapped.place = mapping::FramePlace{frame.place->keyframe, frame.place->keyframe_from_camera};
  }
  return mapped;
}

Expected<void> restore_mapper(mapping::Mapper& mapper, const home::Home& home,
                              home::RecordingId recording, const geometry::PinholeCamera& camera,
                              const features::FeatureExtractor& extractor,
                              const MapSettings& settings, RunContext& run) {
  ROOMWISE_TRY(const auto stored, home.keyframes());
  ROOMWISE_TRY(std::vector<mapping::Keyframe> keyframes,
               measure_keyframes(home, stored, camera, extractor, settings, run));
  ROOMWISE_TRY(auto edges, home.edges());
  ROOMWISE_TRY(const auto frames, home.frames(recording));
  std::vector<mapping::MappedFrame> mapped;
  std::ranges::transform(frames, std::back_inserter(mapped), mapped_frame);
  mapper.restore(std::move(keyframes), std::move(edges), std::move(mapped));
  return {};
}

MapWriter::MapWriter(home::Home& home, home::RecordingId recording, const mapping::Mapper& mapper)
    : home_(home),
      recording_(recording),
      mapper_(mapper),
      edges_written_(mapper.edges().size()),
      frames_written_(mapper.frames().size()) {}

Expected<MapWriter> MapWriter::create(home::Home& home, home::RecordingId recording,
                                      const mapping::Mapper& mapper) {
  MapWriter writer(home, recording, mapper);
  ROOMWISE_TRY(const auto stored, home.keyframes());
  for (const home::Keyframe& keyframe : stored) writer.poses_.push_back(keyframe.pose);
  return writer;
}

Expected<void> MapWriter::write(
    const mapping::MapStep& step,
    const std::function<const image::RgbdFrame&(std::uint64_t)>& frame_of) {
  home::Step stored;
  stored.recording = recording_;
  for (const mapping::KeyframeId id : step.new_keyframes) {
    const mapping::Keyframe& keyframe = mapper_.keyframes()[id];
    poses_.push_back(first_pose(id));
    stored.keyframes.push_back({id,
                                keyframe.frame_index,
                                keyframe.timestamp_ns,
                                poses_.back(),
                                images_of(frame_of(keyframe.frame_index)),
                                {},
                                {}});
    stored.next_frame_index = keyframe.frame_index + 1;
  }
  for (; edges_written_ < mapper_.edges().size(); ++edges_written_) {
    stored.edges.push_back(mapper_.edges()[edges_written_]);
  }
  add_frames_before(stored.next_frame_index, stored);
  return home_.commit_step(stored);
}

Expected<void> MapWriter::write_rest() {
  home::Step stored;
  stored.recording = recording_;
  if (!mapper_.frames().empty()) stored.next_frame_index = mapper_.frames().back().frame_index + 1;
  add_frames_before(stored.next_frame_index, stored);
  return home_.commit_step(stored);
}

home::KeyframePose MapWriter::first_pose(mapping::KeyframeId id) const {
  for (std::size_t i = edges_written_; i < mapper_.edges().size(); ++i) {
    const mapping::PoseGraphEdge& edge = mapper_.edges()[i];
    if (edge.to != id) continue;
    return {poses_[edge.from].world_from_keyframe * edge.from_from_to, poses_[edge.from].piece};
  }
  std::uint64_t pieces = 0;
  for (const home::KeyframePose& pose : poses_) pieces = std::max(pieces, pose.piece + 1);
  return {geometry::RigidTransform::identity(), pieces};
}

void MapWriter::add_frames_before(std::uint64_t index, home::Step& step) {
  while (frames_written_ < mapper_.frames().size() &&
         mapper_.frames()[frames_written_].frame_index < index) {
    step.frames.push_back(stored_frame(mapper_.frames()[frames_written_++]));
  }
}

}  // namespace roomwise::pipeline
