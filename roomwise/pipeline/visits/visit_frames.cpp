#include "roomwise/pipeline/visits/visit_frames.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "roomwise/base/spread.h"
#include "roomwise/mapping/frontend/mapper_options.h"
#include "roomwise/pipeline/in_blocks.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/objects/proposal_observations.h"
#include "roomwise/pipeline/objects/stored_detections.h"

namespace roomwise::pipeline {
namespace {

// Looks at the frames of a visit.
class VisitLooker {
 public:
  static Expected<VisitLooker> create(const home::Home& home,
                                      const objects::DetectionFinders& finders,
                                      const Networks& networks, const VisitOptions& options,
                                      RunContext& run) {
    VisitLooker looker(finders);
    ROOMWISE_TRY(rooms::Concepts concepts, home.concepts());
    looker.vocabulary_ = std::move(concepts.vocabulary);
    if (options.rooms) {
      ROOMWISE_TRY(looker.why_no_rooms_, why_rooms_cannot_be_refreshed(home));
    }
    if (options.rooms && looker.why_no_rooms_.empty()) {
      ROOMWISE_TRY(looker.rooms_,
                   VisitRooms::create(home, networks, *options.rooms, options.localizer, run));
    } else {
      ROOMWISE_TRY(looker.localizer_, HomeLocalizer::create(home, options.localizer, run));
    }
    return looker;
  }

  // Absent where the frame's place is not known.
  struct Look {
    PlacedFrame placed;
    objects::ObservedKeyframe observed;
  };
  [[nodiscard]] Expected<std::optional<Look>> place(image::RgbdFrame frame,
                                                    const geometry::PinholeCamera& camera) const;
  // Absent where they are to stay as they are.
  [[nodiscard]] Expected<std::optional<RoomUpdate>> update_rooms(
      const home::Home& home, std::span<const PlacedFrame> placed) const;
  [[nodiscard]] const objects::ObjectVocabulary& vocabulary() const { return vocabulary_; }

 private:
  explicit VisitLooker(const objects::DetectionFinders& finders) : finders_(&finders) {}
  [[nodiscard]] const HomeLocalizer& localizer() const {
    return rooms_ ? rooms_->localizer() : *localizer_;
  }

  const objects::DetectionFinders* finders_;
  std::optional<VisitRooms> rooms_;
  std::optional<HomeLocalizer> localizer_;  // where there are no rooms_, which have one
  std::string why_no_rooms_;
  objects::ObjectVocabulary vocabulary_;  // of the home
};

Expected<std::optional<VisitLooker::Look>> VisitLooker::place(
    image::RgbdFrame frame, const geometry::PinholeCamera& camera) const {
  PictureToLocate picture{frame.color, std::move(frame.depth), camera};
  ROOMWISE_TRY(const auto measured, localizer().measure(picture));
  const mapping::Localization found = localizer().localizer().locate({measured, camera});
  if (!found.found()) return std::nullopt;
  Look look;
  PlacedFrame& placed = look.placed;
  placed.index = frame.index;
  placed.timestamp_ns = frame.timestamp_ns;
  placed.keyframe = found.keyframe;
  look.observed.world_from_camera = found.world_from_camera;
  look.observed.camera = camera;
  for (const auto& finder : *finders_) {
    ROOMWISE_TRY(auto seen, look_at(*finder, picture.color, *picture.depth, camera));
    look.observed.coarse_depth = std::move(seen.coarse_depth);
    std::ranges::move(objects::classified(std::move(seen.detections), vocabulary_),
                      std::back_inserter(look.observed.detections));
  }
  placed.depth = *std::move(picture.depth);
  if (rooms_) {
    ROOMWISE_TRY(placed.room, rooms_->look(frame, found));
  }
  return look;
}

Expected<std::optional<RoomUpdate>> VisitLooker::update_rooms(
    const home::Home& home, std::span<const PlacedFrame> placed) const {
  if (!why_no_rooms_.empty()) return RoomUpdate{.why_not = why_no_rooms_};
  if (!rooms_) return std::optional<RoomUpdate>();
  std::vector<SeenPicture> walk;
  for (const PlacedFrame& frame : placed) walk.push_back(*frame.room);
  return rooms_->update(home, walk);
}

// All frames of the recording that are found on the map.
Expected<VisitFrames> place_frames(const VisitRecording& visit, const VisitLooker& looker,
                                   const VisitOptions& options, RunContext& run) {
  VisitFrames frames;
  const recording::SourceInfo& info = visit.recording.info();
  frames.visit.name = info.name;
  std::vector<image::RgbdFrame> block;
  const auto place_block = [&]() -> Expected<void> {
    std::vector<Expected<std::optional<VisitLooker::Look>>> looks(block.size(),
                                                                  fail("not placed yet"));
    run.pool.parallel_for(block.size(), [&](std::size_t i) {
      const auto timing = run.clock.measure("placing and looking");
      looks[i] = looker.place(std::move(block[i]), info.camera);
    });
    block.clear();
    for (auto& look : looks) {
      if (!look) return Unexpected(std::move(look).error());
      if (!*look) continue;
      (*look)->observed.keyframe_id = frames.placed.size();
      frames.placed.push_back(std::move((*look)->placed));
      frames.observed.push_back(std::move((*look)->observed));
    }
    return {};
  };
  const std::uint64_t all = visit.recording.frames().size();
  const std::uint64_t every =
      std::max(options.every, (all + options.max_frames - 1) / options.max_frames);
  run.progress.begin("looking at the visit", all);
  for (std::uint64_t count = 0; !run.progress.interrupted(); ++count) {
    ROOMWISE_TRY(auto frame, visit.frames.next());
    if (!frame) break;
    if (count % every != 0) continue;
    if (frames.visit.frames++ == 0) frames.visit.first_timestamp_ns = frame->timestamp_ns;
    frames.visit.last_timestamp_ns = frame->timestamp_ns;
    block.push_back(*std::move(frame));
    if (block.size() >= 2 * run.pool.size()) ROOMWISE_RETURN_IF_ERROR(place_block());
    run.progress.advance(count + 1, "");
  }
  ROOMWISE_RETURN_IF_ERROR(place_block());
  run.progress.end();
  ROOMWISE_RETURN_IF_ERROR(run.progress.check("looking at the visit"));
  frames.visit.placed = frames.placed.size();
  return frames;
}

// Of the placed frames those that a map would have as key-frames: the views between show the same
// once more, and would only outvote others.
std::vector<objects::ObservedKeyframe> spaced_frames(const VisitFrames& frames) {
  const mapping::MapperOptions spacing;
  std::vector<objects::ObservedKeyframe> spaced;
  for (const objects::ObservedKeyframe& frame : frames.observed) {
    if (!spaced.empty()) {
      const geometry::RigidTransform motion =
          spaced.back().world_from_camera.inverse() * frame.world_from_camera;
      if (motion.distance_m() < spacing.keyframe_translation_m &&
          motion.angle_rad() < spacing.keyframe_rotation_rad) {
        continue;
      }
    }
    spaced.push_back(frame);
  }
  return spaced;
}

// Shows the classifier what stands apart in the visit's own depth, from its best views.
Expected<void> look_closer_at_visit(VisitFrames& frames, const recording::Recording& recording,
                                    const objects::ProposalClassifier& proposal_classifier,
                                    const objects::ObjectVocabulary& vocabulary,
                                    const objects::GroundPlane& level, RunContext& run) {
  const auto looked = spaced_frames(frames);
  ProposalObservations proposals = [&] {
    const auto timing = run.clock.measure("what stands apart");
    return ProposalObservations(looked, level);
  }();
  std::vector<std::size_t> shown;  // in frames.placed
  for (const objects::ObservedKeyframe& frame : looked) {
    if (proposals.is_shown_by(frame.keyframe_id)) shown.push_back(frame.keyframe_id);
  }
  ROOMWISE_RETURN_IF_ERROR(in_blocks(
      shown.size(), "looking closer at the visit", run,
      [&](std::size_t i) { return recording.read_color(frames.placed[shown[i]].index); },
      [&](std::size_t i, const image::ColorImage& color) {
        const auto timing = run.clock.measure("region proposals");
        return proposals.look(shown[i], color, frames.placed[shown[i]].depth, proposal_classifier);
      },
      [&](std::size_t i,
          std::vector<ProposalObservations::ViewObservation> observations) -> Expected<void> {
        proposals.keep(shown[i], std::move(observations));
        return {};
      }));
  for (auto& [place, detections] : proposals.detections()) {
    std::ranges::move(objects::classified(std::move(detections), vocabulary),
                      std::back_inserter(frames.observed[place].detections));
  }
  return {};
}

// Where things that people taught were seen last.
Expected<OwnThingSightings> find_own_things_of_visit(const home::Home& home,
                                                     const VisitFrames& frames,
                                                     const recording::Recording& recording,
                                                     const OwnThingWatch& watch, RunContext& run) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const auto looked_at = spread_evenly(frames.placed.size(), kWalkPictures);
  OwnThingSightings last;
  ROOMWISE_RETURN_IF_ERROR(in_blocks(
      looked_at.size(), "looking for what was taught", run,
      [&](std::size_t i) { return recording.read_color(frames.placed[looked_at[i]].index); },
      [&](std::size_t i, const image::ColorImage& color) {
        const PlacedFrame& frame = frames.placed[looked_at[i]];
        const objects::ObservedKeyframe& observed = frames.observed[looked_at[i]];
        const geometry::RigidTransform keyframe_from_world =
            keyframes.at(frame.keyframe).pose.world_from_keyframe.inverse();
        return own_things_in({color, frame.depth, observed.camera, frame.timestamp_ns,
                              frame.keyframe, keyframe_from_world * observed.world_from_camera},
                             watch);
      },
      [&](std::size_t, const OwnThingSightings& seen) -> Expected<void> {
        for (const auto& [id, sighting] : seen) last[id] = sighting;
        return {};
      }));
  return last;
}

}  // namespace

Expected<void> VisitOptions::validate() const {
  if (every < 1) return fail("every is {}; expected at least 1", every);
  if (max_frames < 1) return fail("max_frames is {}; expected at least 1", max_frames);
  ROOMWISE_RETURN_IF_ERROR(localizer.validate());
  return rooms ? rooms->validate() : Expected<void>{};
}

Expected<VisitFrames> observe_visit(const home::Home& home, const VisitRecording& visit,
                                    const objects::ObjectFinders& finders, const Networks& networks,
                                    const objects::GroundPlane& level, const VisitOptions& options,
                                    RunContext& run) {
  ROOMWISE_TRY(const VisitLooker looker,
               VisitLooker::create(home, finders.in_pictures, networks, options, run));
  ROOMWISE_TRY(VisitFrames frames, place_frames(visit, looker, options, run));
  ROOMWISE_TRY(frames.rooms, looker.update_rooms(home, frames.placed));
  if (finders.of_proposals != nullptr) {
    ROOMWISE_RETURN_IF_ERROR(look_closer_at_visit(frames, visit.recording, *finders.of_proposals,
                                                  looker.vocabulary(), level, run));
  }
  if (options.own_things) {
    ROOMWISE_TRY(frames.own_things,
                 find_own_things_of_visit(home, frames, visit.recording, *options.own_things, run));
  }
  return frames;
}

}  // namespace roomwise::pipeline
