#include "roomwise/pipeline/map_recording.h"

#include <algorithm>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/objects/center_point.h"
#include "roomwise/pipeline/measured_frame_reader.h"

namespace roomwise::pipeline {
namespace {

using geometry::RigidTransform;

std::map<home::KeyframeId, home::KeyframePose> poses_by_id(
    std::span<const home::Keyframe> keyframes) {
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (const home::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  return poses;
}

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

// The recording in the home: the unfinished one that is there, or a new one.
Expected<home::StoredRecording> begin_or_resume(home::Home& home, const home::Recording& recording,
                                                const MapSettings& settings) {
  ROOMWISE_TRY(auto stored, home.recordings());
  // A recording of which nothing was mapped begins anew, perhaps with the right camera now.
  if (!stored.empty() && !stored.back().finished && stored.back().next_frame_index == 0) {
    ROOMWISE_CHECK_OK(home.remove_recording(stored.back().id));
    stored.pop_back();
  }
  if (stored.empty()) {
    ROOMWISE_CHECK_OK(home.put_setting("map", to_json(settings)));
    ROOMWISE_TRY(const home::RecordingId id, home.add_recording(recording));
    return home::StoredRecording{id, recording, 0, false};
  }
  const home::StoredRecording& last = stored.back();
  if (last.finished) {
    return fail("{}: holds the finished map of {} already; choose another home file", home.file(),
                last.recording.name);
  }
  if (!(last.recording.camera == recording.camera)) {
    return fail("{}: its recording {} was begun with another camera; choose another home file",
                home.file(), last.recording.name);
  }
  ROOMWISE_TRY(const auto all_settings, home.settings());
  if (const auto own = all_settings.find("map");
      own == all_settings.end() || own->second != to_json(settings)) {
    return fail("{}: its map was begun with other settings", home.file());
  }
  return last;
}

// Gives the mapper back what was stored; features are found again in the stored images, which are
// those that the camera gave.
Expected<void> restore(mapping::Mapper& mapper, const home::Home& home, home::RecordingId recording,
                       const geometry::PinholeCamera& camera,
                       const features::FeatureExtractor& extractor, const MapSettings& settings,
                       RunContext& run) {
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
    std::vector<Expected<motion::MeasuredFeatures>> measured(images.size());
    run.pool.parallel_for(images.size(), [&](std::size_t i) {
      measured[i] = [&]() -> Expected<motion::MeasuredFeatures> {
        ROOMWISE_TRY(const image::ColorImage color, image::decode_color(images[i].color));
        ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images[i].depth));
        return measure_frame(color, depth, camera, extractor, settings.depth);
      }();
    });
    for (std::size_t i = first; i < end; ++i) {
      auto& features = measured[i - first];
      if (!features) {
        return Unexpected(std::move(features).error().in(
            fmt::format("{}: key-frame {}", home.file(), stored[i].id)));
      }
      keyframes.push_back(
          {stored[i].id, stored[i].frame_index, stored[i].timestamp_ns, *std::move(features)});
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

// A frame's images as they are stored: what the camera gave, else encoded without loss, since a
// resumed run finds its features in them again.
home::KeyframeImages images_of(const image::RgbdFrame& frame) {
  return {frame.encoded_color.empty() ? image::encode_png(frame.color) : frame.encoded_color,
          frame.encoded_depth.empty() ? image::encode_png(frame.depth) : frame.encoded_depth};
}

// Writes what the mapper adds into the home, up to each new key-frame: a run that goes on from
// there sees the mapper in the state it had.
class MapWriter {
 public:
  static Expected<MapWriter> create(home::Home& home, home::RecordingId recording,
                                    const mapping::Mapper& mapper) {
    MapWriter writer(home, recording, mapper);
    ROOMWISE_TRY(const auto stored, home.keyframes());
    for (const home::Keyframe& keyframe : stored) writer.poses_.push_back(keyframe.pose);
    return writer;
  }

  // `frame_of` gives the images of the step's key-frames, by frame index.
  Expected<void> write(const mapping::MapStep& step,
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

  // The frames after the last key-frame, when the recording has ended.
  Expected<void> write_rest() {
    home::Step stored;
    stored.recording = recording_;
    if (!mapper_.frames().empty())
      stored.next_frame_index = mapper_.frames().back().frame_index + 1;
    add_frames_before(stored.next_frame_index, stored);
    return home_.commit_step(stored);
  }

 private:
  MapWriter(home::Home& home, home::RecordingId recording, const mapping::Mapper& mapper)
      : home_(home),
        recording_(recording),
        mapper_(mapper),
        edges_written_(mapper.edges().size()),
        frames_written_(mapper.frames().size()) {}

  // Where the next key-frame is as far as is known before the map is solved: along its first edge
  // to an earlier one, or in a new piece of the map. A home that was left unfinished shows its map
  // so.
  home::KeyframePose first_pose(mapping::KeyframeId id) const {
    for (std::size_t i = edges_written_; i < mapper_.edges().size(); ++i) {
      const mapping::PoseGraphEdge& edge = mapper_.edges()[i];
      if (edge.to != id) continue;
      return {poses_[edge.from].world_from_keyframe * edge.from_from_to, poses_[edge.from].piece};
    }
    std::uint64_t pieces = 0;
    for (const home::KeyframePose& pose : poses_) pieces = std::max(pieces, pose.piece + 1);
    return {RigidTransform::identity(), pieces};
  }

  void add_frames_before(std::uint64_t index, home::Step& step) {
    while (frames_written_ < mapper_.frames().size() &&
           mapper_.frames()[frames_written_].frame_index < index) {
      step.frames.push_back(stored_frame(mapper_.frames()[frames_written_++]));
    }
  }

  home::Home& home_;
  home::RecordingId recording_;
  const mapping::Mapper& mapper_;
  std::size_t edges_written_;
  std::size_t frames_written_;
  std::vector<home::KeyframePose> poses_;  // of the key-frames in the home, by id
};

// Takes frames from the source until it ends, fails, or the user interrupts.
Expected<bool> map_frames(recording::FrameSource& source,
                          const features::FeatureExtractor& extractor, const MapSettings& settings,
                          mapping::Mapper& mapper, MapWriter& writer, KeyframeObserver& observer,
                          RunContext& run) {
  MeasuredFrameReader reader(source, extractor, settings.depth, run);
  std::shared_ptr<const image::RgbdFrame> previous;
  run.progress.begin("mapping", source.info().frame_count);
  for (std::uint64_t done = 1; !run.progress.interrupted(); ++done) {
    ROOMWISE_TRY(auto next, reader.next());
    if (!next) {
      run.progress.end();
      return true;
    }
    const std::shared_ptr<const image::RgbdFrame> frame = std::move(next->frame);
    const mapping::MapStep step = [&] {
      const auto timing = run.clock.measure("tracking and loops");
      return mapper.add_frame(frame->index, frame->timestamp_ns, std::move(next->features));
    }();
    if (!step.new_keyframes.empty()) {
      const auto frame_of = [&](std::uint64_t index) -> const image::RgbdFrame& {
        return index == frame->index ? *frame : *previous;
      };
      {
        const auto timing = run.clock.measure("store");
        ROOMWISE_CHECK_OK(writer.write(step, frame_of));
      }
      for (const mapping::KeyframeId id : step.new_keyframes) {
        const auto& owner = mapper.keyframes()[id].frame_index == frame->index ? frame : previous;
        ROOMWISE_CHECK_OK(observer.observe(id, {owner, &owner->color}));
      }
    }
    previous = frame;
    run.progress.advance(done, fmt::format("{} key-frames", mapper.keyframes().size()));
  }
  run.progress.end();
  return false;
}

}  // namespace

Expected<MapSummary> map_recording(recording::FrameSource& source, const home::Recording& recording,
                                   home::Home& home, const Networks& networks,
                                   const MapSettings& settings, RunContext& run) {
  ROOMWISE_CHECK_OK(settings.validate());
  ROOMWISE_TRY(const home::StoredRecording stored, begin_or_resume(home, recording, settings));
  const geometry::PinholeCamera& camera = source.info().camera;
  const auto extractor = features::make_extractor(settings.features, settings.most_keypoints);
  mapping::Mapper mapper(camera, settings.mapper);
  ROOMWISE_CHECK_OK(restore(mapper, home, stored.id, camera, *extractor, settings, run));
  source.skip_before(stored.next_frame_index);
  ROOMWISE_TRY(MapWriter writer, MapWriter::create(home, stored.id, mapper));
  ROOMWISE_TRY(KeyframeObserver observer, KeyframeObserver::create(home, networks, run));

  MapSummary summary;
  Expected<bool> at_end = map_frames(source, *extractor, settings, mapper, writer, observer, run);
  ROOMWISE_CHECK_OK(observer.finish());
  if (!at_end) {
    return mapper.keyframes().empty()
               ? Unexpected(std::move(at_end).error())
               : fail("{}; the {} key-frames before it are kept: resume the map to go on",
                      at_end.error().message, mapper.keyframes().size());
  }
  summary.finished = *at_end;

  if (summary.finished) {
    if (mapper.keyframes().empty()) {
      return fail("{}: no frame has enough features to map; is the lens covered or the room dark?",
                  recording.name);
    }
    ROOMWISE_CHECK_OK(writer.write_rest());
    ROOMWISE_TRY(summary.finished, observer.observe_missing());
  }
  if (summary.finished) {
    const auto timing = run.clock.measure("optimisation");
    ROOMWISE_TRY(const mapping::MapSolution solution, solve_stored_map(home, settings.solver));
    summary.rejected_loops = solution.rejected_loops;
    summary.pieces = solution.pieces;
    summary.graph_error_before = solution.report.error_before;
    summary.graph_error_after = solution.report.error_after;
    for (const mapping::MappedFrame& frame : mapper.frames()) {
      if (frame.place && solution.piece[frame.place->keyframe] == 0) ++summary.placed;
    }
    ROOMWISE_TRY(summary.objects, update_objects(home, settings.objects));
    ROOMWISE_CHECK_OK(home.finish_recording(stored.id));
  }
  ROOMWISE_CHECK_OK(home.add_stage_timings(run.clock.stages()));
  summary.frames = mapper.frames().size();
  summary.keyframes = mapper.keyframes().size();
  summary.loops =
      static_cast<std::uint64_t>(std::ranges::count_if(mapper.edges(), mapping::is_return));
  summary.edges = mapper.edges().size();
  return summary;
}

Expected<mapping::MapSolution> solve_stored_map(home::Home& home,
                                                const mapping::MapSolverOptions& options) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto edges, home.edges());
  ROOMWISE_TRY(mapping::MapSolution solution, mapping::solve_map(keyframes.size(), edges, options));
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (std::size_t id = 0; id < keyframes.size(); ++id) {
    poses[id] = {solution.world_from_keyframe[id], solution.piece[id]};
  }
  ROOMWISE_CHECK_OK(home.replace_poses(poses));
  return solution;
}

Expected<std::uint64_t> update_objects(home::Home& home, const objects::ObjectRules& rules) {
  ROOMWISE_CHECK_OK(rules.validate());
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto networks, home.networks());

  // The first network that names things is the one that is asked.
  std::map<home::KeyframeId, network::Prediction> predictions;
  std::vector<std::string> labels;
  for (const auto& [id, network] : networks) {
    if (network.labels.empty()) continue;
    labels = network.labels;
    ROOMWISE_TRY(predictions, home.predictions(id));
    break;
  }

  std::vector<objects::KeyframeView> views;
  for (const home::Keyframe& keyframe : keyframes) {
    objects::KeyframeView& view = views.emplace_back();
    view.keyframe_id = keyframe.id;
    if (const auto found = predictions.find(keyframe.id); found != predictions.end()) {
      view.sightings = objects::sightings_in(found->second.scores, labels, concepts.vocabulary,
                                             rules.least_score);
    }
    if (view.sightings.empty()) continue;
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframe.id));
    ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
    const auto recording =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id);
    view.center_point = objects::center_point(depth, recording->recording.camera);
  }
  // Pieces of the map that nothing joined have nothing to do with each other.
  std::map<std::uint64_t, std::vector<objects::KeyframeView>> views_of_piece;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    views_of_piece[keyframes[i].pose.piece].push_back(views[i]);
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  std::vector<objects::MapObject> found;
  for (const auto& [piece, views_there] : views_of_piece) {
    const auto there = objects::confirm_objects(
        views_there, rules, [&](std::uint64_t id) { return poses.at(id).world_from_keyframe; });
    found.insert(found.end(), there.begin(), there.end());
  }
  ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
    for (const objects::KeyframeView& view : views) {
      ROOMWISE_CHECK_OK(home.put_sightings(view.keyframe_id, view.sightings));
    }
    return home.replace_objects(found);
  }));
  return found.size();
}

Expected<recording::Trajectory> stored_trajectory(const home::Home& home) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  recording::Trajectory trajectory;
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    for (const home::Frame& frame : frames) {
      if (!frame.place || poses.at(frame.place->keyframe).piece != 0) continue;
      trajectory.push_back(
          {frame.timestamp_ns, poses.at(frame.place->keyframe).world_from_keyframe *
                                   frame.place->keyframe_from_camera});
    }
  }
  return trajectory;
}

}  // namespace roomwise::pipeline
