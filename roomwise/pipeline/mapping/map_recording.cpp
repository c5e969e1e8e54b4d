#include "roomwise/pipeline/mapping/map_recording.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/mapping/camera_check.h"
#include "roomwise/pipeline/mapping/culling.h"
#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/objects/proposal_detection.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/mapper_storage.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {
namespace {

// Takes a walk out of which nothing became. It may have been named already.
Expected<void> drop_walk(home::Home& home, home::RecordingId walk) {
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(take_edits_off(home, walk));
    return home.remove_recording(walk);
  });
}

// The recording in the home: the unfinished one that is there, or a new one.
Expected<home::StoredRecording> begin_or_resume(home::Home& home, const home::Recording& recording,
                                                const MapSettings& settings) {
  ROOMWISE_TRY(auto stored, home.recordings());
  // A recording of which nothing was mapped begins anew, perhaps with the right camera now.
  if (!stored.empty() && !stored.back().finished && stored.back().next_frame_index == 0) {
    ROOMWISE_RETURN_IF_ERROR(drop_walk(home, stored.back().id));
    stored.pop_back();
  }
  ROOMWISE_TRY(const std::optional<MapSettings> own, stored_map_settings(home));
  if (stored.empty()) {
    ROOMWISE_RETURN_IF_ERROR(store_map_settings(home, settings));
  } else if (!own || to_json(*own) != to_json(settings)) {
    return fail("{}: its map was begun with other settings", home.file());
  }
  if (stored.empty() || stored.back().finished) {
    ROOMWISE_TRY(const home::RecordingId id, home.add_recording(recording));
    home::StoredRecording added;
    added.id = id;
    added.recording = recording;
    return added;
  }
  const home::StoredRecording& last = stored.back();
  if (!(last.recording.camera == recording.camera)) {
    return fail("{}: its recording {} was begun with another camera; choose another home file",
                home.file(), last.recording.name);
  }
  return last;
}

// Pictures of a video, or of another size, may be computed a little otherwise by another library.
bool is_nearly_same(const image::ColorImage& one, const image::ColorImage& other) {
  if (one.width() != other.width() || one.height() != other.height()) return false;
  constexpr double kMaxMeanDifference = 8;  // of 255
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < one.pixels().size(); ++i) {
    const Rgb8 a = one.pixels()[i], b = other.pixels()[i];
    sum +=
        static_cast<std::uint64_t>(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b));
  }
  return static_cast<double>(sum) <=
         3 * kMaxMeanDifference * static_cast<double>(one.pixels().size());
}

// Whether the home's picture of a key-frame is the frame's, to the bit or nearly; absent where it
// cannot be read.
template <typename IsSame>
Expected<std::optional<bool>> is_of_frame(const home::Home& home, home::KeyframeId keyframe,
                                          const image::RgbdFrame& frame, const RunContext& run,
                                          const IsSame& is_same) {
  const auto images = home.images(keyframe);
  if (!images) ROOMWISE_RETURN_IF_ERROR(go_on_without(home, keyframe, images.error(), run.lost));
  const auto color = images ? image::decode_color(images->color) : Unexpected(images.error());
  if (!color) return std::nullopt;
  return is_same(*color, frame.color);
}

// A map goes on with the frames of the recording that it was begun with: the newest key-frame's
// frame must be there, taken at the same time, and show the same. Times alone may be made up.
Expected<void> go_to_next_frame(recording::FrameSource& source, const home::Home& home,
                                const home::StoredRecording& stored, const RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  if (!keyframes.empty() && keyframes.back().recording == stored.id) {
    source.skip_before(keyframes.back().frame_index);
    ROOMWISE_TRY(const auto frame, source.next());
    bool is_same = frame && frame->index == keyframes.back().frame_index &&
                   frame->timestamp_ns == keyframes.back().timestamp_ns;
    if (is_same) {
      ROOMWISE_TRY(const auto is_seen,
                   is_of_frame(home, keyframes.back().id, *frame, run, is_nearly_same));
      is_same = is_seen.value_or(true);
    }
    if (!is_same) {
      return fail("{}: holds the unfinished map of {}, and {} is another recording; give that one",
                  home.file(), stored.recording.name, source.info().name);
    }
  }
  source.skip_before(stored.next_frame_index);
  return {};
}

// A walk that the home holds already begins with the same key-frame: nothing is to be doubled.
// Where its stored images cannot be read again, its time and the walk's name, length and camera
// say so.
Expected<void> check_is_new(const home::Home& home, const home::Recording& recording,
                            const image::RgbdFrame& first_keyframe, const RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::Keyframe& keyframe : keyframes) {
    if (keyframe.frame_index != first_keyframe.index ||
        keyframe.timestamp_ns != first_keyframe.timestamp_ns) {
      continue;
    }
    const home::Recording& known =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id)->recording;
    ROOMWISE_TRY(const auto is_seen,
                 is_of_frame(home, keyframe.id, first_keyframe, run, std::equal_to<>()));
    const bool is_same =
        is_seen.value_or(known.name == recording.name && known.camera == recording.camera &&
                         known.frame_count == recording.frame_count);
    if (!is_same) continue;
    return fail_with(ErrorCode::kRefused,
                     "{}: holds this recording already, as {}; nothing was added", home.file(),
                     known.name);
  }
  return {};
}

// Takes frames from the source until it ends; fails as it does, and where the user interrupts.
Expected<void> map_frames(recording::FrameSource& source, const home::Home& home,
                          const features::FeatureExtractor& extractor, const MapSettings& settings,
                          const home::Recording& recording, mapping::Mapper& mapper,
                          MapWriter& writer, KeyframeObserver& observer, RunContext& run) {
  bool is_begun = writer.has_begun();
  MeasuredFrameReader reader(source, extractor, settings, run);
  std::shared_ptr<const image::RgbdFrame> previous;
  run.progress.begin("mapping", source.info().frames_remaining);
  for (std::uint64_t done = 1; !run.progress.interrupted(); ++done) {
    ROOMWISE_TRY(auto next, reader.next());
    if (!next) {
      run.progress.end();
      return {};
    }
    const std::shared_ptr<const image::RgbdFrame> frame = std::move(next->frame);
    ROOMWISE_TRY(const mapping::MapUpdate step, [&] {
      const auto timing = run.clock.measure("tracking and loops");
      return mapper.add_frame(frame->index, frame->timestamp_ns, std::move(next->measurements),
                              frame->device_motion);
    }());
    if (!step.new_keyframes.empty() && !std::exchange(is_begun, true))
      ROOMWISE_RETURN_IF_ERROR(check_is_new(home, recording, *frame, run));
    {
      const auto timing = run.clock.measure("store");
      ROOMWISE_RETURN_IF_ERROR(
          writer.write(step, [&](std::uint64_t index) -> const image::RgbdFrame& {
            return index == frame->index ? *frame : *previous;
          }));
    }
    for (const mapping::KeyframeId id : step.new_keyframes) {
      const auto& owner = mapper.keyframes()[id].frame_index == frame->index ? frame : previous;
      ROOMWISE_RETURN_IF_ERROR(observer.observe(id, owner, source.info().camera));
    }
    previous = frame;
    run.progress.advance(done, fmt::format("{} key-frames", mapper.keyframes().size()));
  }
  run.progress.end();
  return run.progress.check("mapping");
}

// Finds what landmarks are found by in key-frames that the mapper holds, one after the other.
Expected<mapping::FindFeatures> landmark_features(const home::Home& home, mapping::Mapper& mapper,
                                                  const MapSettings& settings) {
  ROOMWISE_TRY(auto cameras, recording_cameras(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::vector<home::RecordingId> recording_of;
  for (const home::Keyframe& one : keyframes) recording_of.push_back(one.recording);
  return [&mapper, &settings, cameras = std::move(cameras),
          recording_of = std::move(recording_of)](std::span<const home::KeyframeId> ids)
             -> Expected<std::vector<mapping::KeyframeFeatures>> {
    std::vector<mapping::KeyframeFeatures> features;
    for (const home::KeyframeId id : ids) {
      ROOMWISE_TRY(const auto measurements, mapper.measurements(id));
      features.push_back(mapping::keyframe_features(*measurements, cameras.at(recording_of[id]),
                                                    settings.refinement.landmarks,
                                                    settings.refinement.uses_gravity));
    }
    return features;
  };
}

// Whether a key-frame of the walk lies in one component with one of an earlier walk. The first walk
// has none to join.
bool is_joined(std::span<const home::Keyframe> keyframes, home::RecordingId walk) {
  std::set<std::uint64_t> of_earlier, of_walk;
  for (const home::Keyframe& one : keyframes)
    (one.recording == walk ? of_walk : of_earlier).insert(one.pose.component);
  return of_earlier.empty() || std::ranges::any_of(of_walk, [&](std::uint64_t component) {
           return of_earlier.contains(component);
         });
}

std::uint64_t count_components(std::span<const home::Keyframe> keyframes) {
  std::set<std::uint64_t> components;
  for (const home::Keyframe& one : keyframes) components.insert(one.pose.component);
  return components.size();
}

// The localiser's index of the map that the walk joins, where the home keeps it.
Expected<std::optional<KeptLocalizerIndex>> index_before(const home::Home& home,
                                                         const MapSettings& settings) {
  if (settings.mapper.method == mapping::MappingMethod::kPaper) return std::nullopt;
  return take_localizer_index(home);
}

// What a walk's map has come to once all its frames are stored, so that a run that was killed goes
// on behind it: what comes before is not to be done twice, since it begins with the poses and
// key-frames that it changes.
enum class MapStage : std::uint8_t { kStored, kSolved, kCulled };
const std::string kStageName = "map stage";
Expected<MapStage> stage_of(const home::Home& home, home::RecordingId walk) {
  ROOMWISE_TRY(const auto stored, home.derived_data(kStageName));
  if (!stored || stored->made_from != std::to_string(walk) || stored->data.size() != 1 ||
      stored->data.front() > static_cast<std::uint8_t>(MapStage::kCulled)) {
    return MapStage::kStored;
  }
  return static_cast<MapStage>(stored->data.front());
}
Expected<void> put_stage(home::Home& home, home::RecordingId walk, MapStage stage) {
  return home.put_derived_data(
      {kStageName, std::to_string(walk), {static_cast<std::uint8_t>(stage)}});
}

Expected<void> solve(home::Home& home, const MapSettings& settings, mapping::Mapper& mapper,
                     home::RecordingId walk, RunContext& run, MapSummary& summary) {
  const auto timing = run.clock.measure("optimisation");
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const mapping::FindFeatures features, landmark_features(home, mapper, settings));
    ROOMWISE_TRY(SolvedMap solved, solve_stored_map(home, settings, features, run.progress));
    if (solved.refinement) {
      summary.landmarks = solved.refinement->landmarks;
      summary.landmark_views = solved.refinement->views;
      summary.readout_s = solved.refinement->readout_s;
      summary.contradicted_gravity = solved.refinement->contradicted_gravity;
    }
    summary.rejected_edges = solved.solution.rejected_edges;
    for (const auto& [id, why] : solved.unread) {
      const bool is_told = run.lost != nullptr && run.lost->all().contains(id);
      if (!is_told) summary.unread.push_back(why);
    }
    summary.graph_error_before = solved.solution.report.error_before;
    summary.graph_error_after = solved.solution.report.error_after;
    return put_stage(home, walk, MapStage::kSolved);
  });
}

// Of the walk before this one, key-frames that add nothing to what the walks before it show. This
// one stays whole until the next: what stands where now is known by it.
Expected<void> cull_walk_before(home::Home& home, const MapSettings& settings, RunContext& run,
                                MapSummary& summary) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (!settings.culls_keyframes() || recordings.size() < 3) return {};
  const auto timing = run.clock.measure("culling");
  ROOMWISE_TRY(const CullingVerdicts verdicts,
               judge_keyframes(home, recordings[recordings.size() - 2].id, {}, run));
  const std::vector<home::KeyframeId> culled = redundant_of(verdicts);
  summary.culled = culled.size();
  return cull_keyframes(home, culled, settings, run.lost);
}

// Poses, things, the localiser's index, and what need not be kept. `mapper` holds what the home
// does, as it was when this run began to store.
Expected<void> finish_map(home::Home& home, const MapSettings& settings, mapping::Mapper& mapper,
                          home::RecordingId walk, const objects::ObjectFinders& finders,
                          std::optional<KeptLocalizerIndex> before, RunContext& run,
                          MapSummary& summary) {
  ROOMWISE_TRY(const MapStage stage, stage_of(home, walk));
  if (stage == MapStage::kCulled) return {};
  mapper.release_index();
  if (stage == MapStage::kStored)
    ROOMWISE_RETURN_IF_ERROR(solve(home, settings, mapper, walk, run, summary));
  if (finders.of_proposals)
    ROOMWISE_RETURN_IF_ERROR(redetect_on_proposals(home, *finders.of_proposals, run));
  {
    const auto timing = run.clock.measure("joining objects");
    ROOMWISE_RETURN_IF_ERROR(
        update_objects(home, settings.objects, run.lost).map([](const FoundObjects&) {}));
  }
  // A map of the paper's method holds no views: its localiser measures them when it is first used.
  if (settings.mapper.method != mapping::MappingMethod::kPaper) {
    const auto timing = run.clock.measure("localiser");
    ROOMWISE_RETURN_IF_ERROR(keep_localizer_index(
        home, [&](home::KeyframeId id) { return mapper.measurements(id); }, std::move(before)));
  }
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(cull_walk_before(home, settings, run, summary));
    return put_stage(home, walk, MapStage::kCulled);
  });
}

void count_motion(std::span<const scene::Frame> frames, bool tells_motion, MapSummary& summary) {
  for (const scene::Frame& frame : frames) {
    if (!frame.motion) continue;
    if (frame.motion->device.up_camera) ++summary.felt_up;
    if (!tells_motion) continue;
    ++summary.with_device_motion;
    if (frame.motion->use == scene::MotionUse::kDropped) ++summary.motion_dropped;
    if (frame.motion->use == scene::MotionUse::kAlone) ++summary.motion_alone;
  }
}

}  // namespace

Expected<MapSummary> map_recording(recording::FrameSource& source, const home::Recording& recording,
                                   home::Home& home, const Networks& networks,
                                   const MapSettings& settings, RunContext& run,
                                   const objects::ObjectFinders& finders,
                                   const std::function<Expected<void>()>& name_rooms,
                                   const geometry::InertialTrack& inertial) {
  ROOMWISE_RETURN_IF_ERROR(settings.validate());
  ROOMWISE_TRY(const home::StoredRecording stored, begin_or_resume(home, recording, settings));
  ROOMWISE_RETURN_IF_ERROR(go_to_next_frame(source, home, stored, run));
  const geometry::PinholeCamera& camera = source.info().camera;
  const auto extractor = features::make_extractor(settings.features, settings.max_keypoints);
  const std::filesystem::path folder = std::filesystem::absolute(home.file()).parent_path();
  mapping::Mapper mapper(camera, settings.mapper, {run.working_set_bytes, folder});
  if (!inertial.empty()) mapper.feel(inertial);
  ROOMWISE_TRY(std::optional<KeptLocalizerIndex> index, index_before(home, settings));
  std::optional<KnownAppearances> known;
  if (index) known = {index->index.appearances(), index->keyframes};
  ROOMWISE_RETURN_IF_ERROR(
      restore_mapper(mapper, home, stored.id, *extractor, settings, run, std::move(known)));
  ROOMWISE_TRY(MapWriter writer, MapWriter::create(home, stored.id, mapper));
  ROOMWISE_TRY(KeyframeObserver observer,
               KeyframeObserver::create(home, networks, finders.in_pictures, run));

  MapSummary summary;
  summary.is_by_inertial_sensor = inertial.tells_turns() && settings.mapper.takes_device_motion();
  const auto is_error = [](const Expected<void>& outcome) {
    return !outcome && outcome.error().code != ErrorCode::kInterrupted;
  };
  Expected<void> outcome =
      map_frames(source, home, *extractor, settings, recording, mapper, writer, observer, run);
  ROOMWISE_RETURN_IF_ERROR(observer.finish());
  const auto keyframes_of_walk = [&] {
    return mapper.keyframes().size() - writer.first_keyframe();
  };
  if (is_error(outcome)) {
    if (writer.has_begun()) {
      return fail("{}; the {} key-frames before it are kept: resume the map to go on",
                  outcome.error().message, keyframes_of_walk());
    }
    ROOMWISE_RETURN_IF_ERROR(drop_walk(home, stored.id));
    return Unexpected(std::move(outcome).error());
  }
  const auto finish = [&]() -> Expected<void> {
    if (keyframes_of_walk() == 0) {
      ROOMWISE_RETURN_IF_ERROR(drop_walk(home, stored.id));
      return fail("{}: no frame has enough features to map; is the lens covered or the room dark?",
                  recording.name);
    }
    ROOMWISE_RETURN_IF_ERROR(writer.write_rest());
    ROOMWISE_RETURN_IF_ERROR(observer.observe_missing());
    ROOMWISE_TRY(summary.focal_length, check_focal_length(mapper, writer.first_keyframe(), camera,
                                                          settings.mapper.seed, run));
    ROOMWISE_RETURN_IF_ERROR(
        finish_map(home, settings, mapper, stored.id, finders, std::move(index), run, summary));
    {
      ROOMWISE_TRY(const auto keyframes, home.keyframes());
      summary.components = count_components(keyframes);
      summary.is_joined = is_joined(keyframes, stored.id);
      ROOMWISE_TRY(const recording::Trajectory trajectory, stored_trajectory(home, stored.id));
      summary.placed = trajectory.size();
      ROOMWISE_TRY(const auto frames, home.frames(stored.id));
      count_motion(frames, inertial.empty() || inertial.tells_turns(), summary);
      ROOMWISE_TRY(const auto instances, home.instances());
      summary.instances = instances.size();
      ROOMWISE_TRY(const auto by_rules, home.confirmed_objects());
      summary.objects = by_rules.size();
    }
    const auto timing = run.clock.measure("floor");
    ROOMWISE_RETURN_IF_ERROR(keep_home_floor(home, run));
    return home.atomically([&]() -> Expected<void> {
      if (name_rooms) ROOMWISE_RETURN_IF_ERROR(name_rooms());
      return home.finish_recording(stored.id);
    });
  };
  if (outcome) outcome = finish();
  if (is_error(outcome)) return Unexpected(std::move(outcome).error());
  summary.finished = outcome.has_value();
  ROOMWISE_RETURN_IF_ERROR(home.add_stage_timings(run.clock.stages()));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  summary.walks = recordings.size();
  summary.frames = mapper.frame_count();
  summary.keyframes = keyframes_of_walk();
  summary.loops =
      static_cast<std::uint64_t>(std::ranges::count_if(mapper.edges(), mapping::spans_long_loop));
  summary.edges = mapper.edges().size();
  return summary;
}

}  // namespace roomwise::pipeline
