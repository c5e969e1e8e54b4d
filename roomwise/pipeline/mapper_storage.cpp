#include "roomwise/pipeline/mapper_storage.h"

#include <algorithm>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/measured_frame_reader.h"

namespace roomwise::pipeline {
namespace {

home::Frame stored_frame(const mapping::MappedFrame& frame) {
  home::Frame stored{frame.frame_index, frame.timestamp_ns, std::nullopt, frame.why_unplaced};
  if (frame.place)
    stored.place = home::FramePlace{frame.place->keyframe, frame.place->keyframe_from_camera};
  return stored;
}

mapping::MappedFrame mapped_frame(const home::Frame& frame) {
  mapping::MappedFrame mapped{frame.index, frame.timestamp_ns, std::nullopt, frame.no_pose_reason};
  if (frame.place) {
    mapped.place = mapping::FramePlace{frame.place->keyframe, frame.place->keyframe_from_camera};
  }
  return mapped;
}

// As the camera gave them, else encoded without loss: a resumed run finds its features in them
// again.
home::KeyframeImages images_of(const image::RgbdFrame& frame) {
  return {frame.encoded_color.empty() ? image::encode_png(frame.color) : frame.encoded_color,
          frame.encoded_depth.empty() ? image::encode_png(frame.depth) : frame.encoded_depth};
}

Expected<motion::FrameMeasurements> measure_stored(const home::KeyframeImages& images,
                                                   const geometry::PinholeCamera& camera,
                                                   const features::FeatureExtractor& extractor,
                                                   const MapSettings& settings) {
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(images.color));
  ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
  return measure_frame(color, depth, camera, extractor, settings);
}

}  // namespace

Expected<void> restore_mapper(mapping::Mapper& mapper, const home::Home& home,
                              home::RecordingId recording, const geometry::PinholeCamera& camera,
                              const features::FeatureExtractor& extractor,
                              const MapSettings& settings, RunContext& run) {
  ROOMWISE_TRY(const auto stored, home.keyframes());
  std::vector<mapping::Keyframe> keyframes;
  run.progress.begin("loading the map", stored.size());
  // In blocks: reading is the database's, finding features the threads' work.
  const std::size_t block = 4 * run.pool.size();
  for (std::size_t first = 0; first < stored.size(); first += block) {
    const std::size_t end = std::min(stored.size(), first + block);
    std::vector<home::KeyframeImages> images;
    for (std::size_t i = first; i < end; ++i) {
      ROOMWISE_TRY(home::KeyframeImages one, home.images(stored[i].id));
      images.push_back(std::move(one));
    }
    std::vector<Expected<motion::FrameMeasurements>> measured(images.size(), fail("not measured"));
    run.pool.parallel_for(images.size(), [&](std::size_t i) {
      measured[i] = measure_stored(images[i], camera, extractor, settings);
    });
    for (std::size_t i = first; i < end; ++i) {
      auto& measurements = measured[i - first];
      if (!measurements) {
        return Unexpected(std::move(measurements)
                              .error()
                              .in(fmt::format("{}: key-frame {}", home.file(), stored[i].id)));
      }
      keyframes.push_back(
          {stored[i].id, stored[i].frame_index, stored[i].timestamp_ns, *std::move(measurements)});
    }
    run.progress.advance(end, "");
  }
  run.progress.end();
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
