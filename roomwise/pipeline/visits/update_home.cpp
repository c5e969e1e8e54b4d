#include "roomwise/pipeline/visits/update_home.h"

#include <algorithm>
#include <map>
#include <utility>

#include "roomwise/base/shell_word.h"
#include "roomwise/objects/instances/upright_box.h"
#include "roomwise/pipeline/objects/stored_detections.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using geometry::RigidTransform;
using objects::PlacedInstance;

std::vector<Eigen::Vector3f> transformed(std::span<const Eigen::Vector3f> points,
                                         const RigidTransform& transform) {
  std::vector<Eigen::Vector3f> result;
  for (const Eigen::Vector3f& point : points) {
    result.push_back((transform * point.cast<double>()).cast<float>());
  }
  return result;
}

// The things of a home, and what it takes to compare them with those of a visit.
class VisitComparison {
 public:
  static Expected<VisitComparison> create(const home::Home& home) {
    VisitComparison result;
    ROOMWISE_TRY(result.keyframes_, home.keyframes());
    ROOMWISE_TRY(result.instances_, home.instances());
    ROOMWISE_TRY(result.past_, home.past_instances());
    ROOMWISE_TRY(result.visits_, home.visits());
    ROOMWISE_TRY(result.rooms_, rooms_of_keyframes(home));
    // By the names of programs, which the visit's pictures are compared by.
    ROOMWISE_TRY(const HomeHistory history, home_history_as_found(home));
    for (const ThingHistory& one : history.things) {
      if (one.is_gone) result.gone_or_moved_.push_back(one.thing);
      for (const WalkEvent& event : one.events) {
        if (event.from) result.gone_or_moved_.push_back(*event.from);
      }
    }
    return result;
  }

  HomeUpdate compare(const std::vector<objects::ObservedKeyframe>& looked_before,
                     const objects::GroundPlane& level, const VisitFrames& frames,
                     const UpdateOptions& options, RunContext& run) {
    take_before(looked_before, level);
    now_instances_ = objects::find_instances(frames.observed, level, options.instances);
    for (const objects::Instance& one : now_instances_) {
      const auto& shows_best = frames.observed[one.keyframe_id];
      now_.push_back(objects::placed_instance(one, one.box_world(shows_best.world_from_camera),
                                              frames.observed, level));
    }
    const auto views_before = views_of(looked_before);
    const auto views_now = views_of(frames);
    const objects::Changes changes = objects::find_changes(before_, views_before, now_, views_now,
                                                           past_things(), options.changes);
    HomeUpdate update;
    update.changes.visit = frames.visit;
    update.rooms = frames.rooms;
    update.own_things = frames.own_things;
    if (frames.rooms) update.changes.pictures = frames.rooms->pictures;
    report_known(changes, frames, update);
    for (const objects::ArrivedInstance& arrival : changes.arrived) {
      ThingUpdate thing;
      thing.is_new = true;
      thing.evidence_now = arrival.evidence;
      stand_now(arrival.now, frames, thing, update.changes);
      update.things.push_back(std::move(thing));
    }
    const ThingPlaces told = places_told_of(changes, update.things);
    for (const objects::SurfaceChange& change : objects::find_surface_changes(
             views_before, views_now, level, options.surfaces, run.pool)) {
      if (lies_in(change, change.is_new ? told.now : told.before)) continue;
      const home::KeyframeId shows = change.is_new ? frames.placed[change.shown_by].keyframe
                                                   : looked_before[change.shown_by].keyframe_id;
      update.unnamed.push_back(
          {change.is_new, change.box_world, room_of(shows),
           name_beside(change.box_world.center(), room_of(shows), update.things),
           objects::is_like_a_leaf(change.box_world, level), change.evidence});
    }
    return update;
  }

 private:
  [[nodiscard]] const home::KeyframePose& pose_of(const objects::Instance& one) const {
    return keyframes_.at(one.keyframe_id).pose;
  }

  // Only what lies in the map's largest component has a place in the world of the visit's frames.
  void take_before(const std::vector<objects::ObservedKeyframe>& looked,
                   const objects::GroundPlane& level) {
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      const objects::Instance& one = instances_[i];
      const home::KeyframePose& pose = pose_of(one);
      if (pose.component != 0) continue;
      const geometry::OrientedBox box = one.box_world(pose.world_from_keyframe);
      std::vector<std::size_t> supporting_keyframes;
      PlacedInstance thing =
          objects::placed_instance(one, box, looked, level, &supporting_keyframes);
      std::pair<TimestampNs, TimestampNs> seen{keyframes_[one.keyframe_id].timestamp_ns,
                                               keyframes_[one.keyframe_id].timestamp_ns};
      for (const std::size_t k : supporting_keyframes) {
        const TimestampNs time_ns = keyframes_.at(looked[k].keyframe_id).timestamp_ns;
        seen = {std::min(seen.first, time_ns), std::max(seen.second, time_ns)};
      }
      if (one.visit != 0) {
        thing.surface_world = transformed(one.surface_keyframe, pose.world_from_keyframe);
        const home::Visit& visit = visits_.at(one.visit);
        seen = {visit.first_timestamp_ns, visit.last_timestamp_ns};
      }
      known_.push_back(i);
      seen_.push_back(seen);
      before_.push_back(std::move(thing));
    }
  }

  [[nodiscard]] std::vector<PlacedInstance> past_things() const {
    std::vector<PlacedInstance> things;
    const auto add = [&](const objects::Instance& past) {
      const home::KeyframePose& pose = pose_of(past);
      if (pose.component != 0) return;
      things.push_back({past.name, past.box_world(pose.world_from_keyframe), {}});
    };
    for (const home::PastInstance& past : past_) add(past.instance);
    for (const objects::Instance& past : gone_or_moved_) add(past);
    return things;
  }

  static std::vector<objects::DepthView> views_of(
      const std::vector<objects::ObservedKeyframe>& looked) {
    std::vector<objects::DepthView> views;
    for (const objects::ObservedKeyframe& one : looked) {
      views.push_back(
          {one.world_from_camera, &one.camera, &one.coarse_depth, objects::kCoarseDepthStep_px});
    }
    return views;
  }
  static std::vector<objects::DepthView> views_of(const VisitFrames& frames) {
    std::vector<objects::DepthView> views;
    for (const objects::ObservedKeyframe& frame : frames.observed) {
      views.push_back(
          {frame.world_from_camera, &frame.camera, &frames.placed[frame.keyframe_id].depth, 1});
    }
    return views;
  }

  // Things that the home knew; what did not change is kept, other components too.
  void report_known(const objects::Changes& changes, const VisitFrames& frames,
                    HomeUpdate& update) {
    std::size_t at = 0;  // in known_
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      if (at == known_.size() || known_[at] != i) {
        update.changes.kept.push_back(instances_[i]);
        continue;
      }
      const objects::InstanceChange& state = changes.before[at];
      const objects::Instance& one = instances_[i];
      ThingUpdate thing;
      thing.state = state.state;
      thing.name = one.name;
      thing.probability = one.probability;
      thing.evidence = state.evidence;
      thing.evidence_now = state.evidence_now;
      thing.before = before_[at].box_world;
      thing.room_before = room_of(one.keyframe_id);
      if (!thing.is_changed()) {
        thing.now = thing.before;
        thing.room_now = thing.room_before;
        update.changes.kept.push_back(one);
      } else {
        home::PastInstance past{.instance = one,
                                .reason = state.state == objects::ChangeState::kRemoved
                                              ? home::PastReason::kRemoved
                                              : home::PastReason::kMoved,
                                .first_seen_ns = seen_[at].first,
                                .last_seen_ns = seen_[at].second};
        past.instance.surface_keyframe.clear();
        update.changes.past.push_back(std::move(past));
        if (state.now) stand_now(*state.now, frames, thing, update.changes);
        if (state.state == objects::ChangeState::kShifted) {
          update.changes.arrived.push_back(nearly_there(at, frames));
          thing.now = thing.before;
          thing.room_now = thing.room_before;
        }
      }
      update.things.push_back(std::move(thing));
      ++at;
    }
  }

  // Where one of the visit's things stands, and the instance that the home gets of it: relative to
  // the key-frame that shows the same as the frame that shows it best.
  void stand_now(std::size_t now, const VisitFrames& frames, ThingUpdate& thing,
                 home::HomeChanges& changes) const {
    const PlacedFrame& frame = frames.placed[now_instances_[now].keyframe_id];
    objects::Instance instance = now_instances_[now];
    thing.name = instance.name;
    thing.probability = instance.probability;
    thing.now = now_[now].box_world;
    thing.room_now = room_of(frame.keyframe);
    const RigidTransform keyframe_from_world =
        keyframes_.at(frame.keyframe).pose.world_from_keyframe.inverse();
    instance.keyframe_id = frame.keyframe;
    instance.picture_box = {};
    instance.box_keyframe = {keyframe_from_world * thing.now->world_from_box, thing.now->size_m};
    instance.surface_keyframe = transformed(now_[now].surface_world, keyframe_from_world);
    changes.arrived.push_back(std::move(instance));
  }

  // What was shifted and not found again: where it was, less surely, with what is left there.
  [[nodiscard]] objects::Instance nearly_there(std::size_t at, const VisitFrames& frames) const {
    objects::Instance instance = instances_[known_[at]];
    instance.picture_box = {};
    instance.sigma_m += Eigen::Vector3d(objects::kShiftSigma_m, objects::kShiftSigma_m, 0);
    instance.surface_keyframe =
        transformed(objects::remaining_surface(before_[at].surface_world, views_of(frames)),
                    pose_of(instance).world_from_keyframe.inverse());
    return instance;
  }

  // Where things stood that went, and stand that came, by this visit or an earlier one: the map's
  // depth shows them as they were when it was made.
  struct ThingPlaces {
    std::vector<geometry::OrientedBox> before, now;
  };
  [[nodiscard]] ThingPlaces places_told_of(const objects::Changes& changes,
                                           std::span<const ThingUpdate> things) const {
    ThingPlaces places;
    for (const ThingUpdate& thing : things) {
      if (!thing.is_changed()) continue;
      if (thing.before) places.before.push_back(*thing.before);
      if (thing.now) places.now.push_back(*thing.now);
    }
    for (const PlacedInstance& thing : past_things()) places.before.push_back(thing.box_world);
    for (std::size_t at = 0; at < known_.size(); ++at) {
      const objects::ChangeState state = changes.before[at].state;
      const bool stands =
          state != objects::ChangeState::kRemoved && state != objects::ChangeState::kMoved;
      if (stands && instances_[known_[at]].visit != 0) places.now.push_back(before_[at].box_world);
    }
    return places;
  }

  // Whether a part of a changed surface, or more, lies in the boxes.
  static bool lies_in(const objects::SurfaceChange& change,
                      std::span<const geometry::OrientedBox> boxes) {
    constexpr double kSlack_m = 0.1, kPart = 0.3;
    const double part = kPart * static_cast<double>(change.surface_world.size());
    const auto inside =
        std::ranges::count_if(change.surface_world, [&](const Eigen::Vector3f& point) {
          return std::ranges::any_of(boxes, [&](const geometry::OrientedBox& box) {
            return box.distance_m(point.cast<double>()) <= kSlack_m;
          });
        });
    return static_cast<double>(inside) > part;
  }

  // The thing that stands nearest to a place now, within reach of it and not in another room;
  // empty: none.
  static std::string name_beside(const Eigen::Vector3d& place_world, const std::string& room,
                                 std::span<const ThingUpdate> things) {
    double min_m = 0.5;
    std::string name;
    for (const ThingUpdate& thing : things) {
      if (!thing.now || thing.state == objects::ChangeState::kUnobserved) continue;
      if (!room.empty() && !thing.room_now.empty() && thing.room_now != room) continue;
      if (thing.now->distance_m(place_world) >= min_m) continue;
      min_m = thing.now->distance_m(place_world);
      name = thing.name;
    }
    return name;
  }

  [[nodiscard]] std::string room_of(home::KeyframeId id) const {
    const auto room = rooms_.find(id);
    return room == rooms_.end() ? std::string() : room->second;
  }

  std::vector<home::Keyframe> keyframes_;
  std::vector<objects::Instance> instances_;
  std::vector<home::PastInstance> past_;
  std::vector<objects::Instance> gone_or_moved_;  // by what walks of the map found, as they stood
  std::map<home::VisitId, home::Visit> visits_;
  KeyframeRooms rooms_;
  // Of the home's things that have a place: which instance, when it was seen, where it stands.
  std::vector<std::size_t> known_;
  std::vector<std::pair<TimestampNs, TimestampNs>> seen_;
  std::vector<PlacedInstance> before_;
  std::vector<objects::Instance> now_instances_;
  std::vector<PlacedInstance> now_;  // the same
};

}  // namespace

Expected<void> UpdateOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(visit.validate());
  ROOMWISE_RETURN_IF_ERROR(instances.validate());
  ROOMWISE_RETURN_IF_ERROR(surfaces.validate());
  return changes.validate();
}

Expected<HomeUpdate> compare_with_visit(const home::Home& home, const VisitRecording& visit,
                                        const objects::ObjectFinders& finders,
                                        const Networks& networks, const UpdateOptions& options,
                                        RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (finders.in_pictures.empty()) {
    return fail("no detector is here to look at the visit; get one: roomwise networks list");
  }
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  if (keyframes.empty()) return fail("{}: has no map; make one: roomwise map", home.file());
  ROOMWISE_TRY(const auto components, observed_keyframes(home));
  if (!components.contains(0)) {
    return fail("{}: no detector has looked at this home; let one: roomwise objects find --home {}",
                home.file(), shell_word(home.file()));
  }
  const objects::GroundPlane level = objects::fit_ground_plane(components.at(0));
  ROOMWISE_TRY(const VisitFrames frames,
               observe_visit(home, visit, finders, networks, level, options.visit, run));
  if (frames.placed.size() < 2) {
    return fail("{}: only {} of {} frames were found on the map of {}; is it the same home?",
                visit.recording.info().name, frames.placed.size(), frames.visit.frames,
                home.file());
  }
  const auto timing = run.clock.measure("comparing");
  ROOMWISE_TRY(VisitComparison comparison, VisitComparison::create(home));
  run.progress.begin("comparing with the map", 1);
  HomeUpdate update = comparison.compare(components.at(0), level, frames, options, run);
  run.progress.advance(1, "");
  run.progress.end();
  ROOMWISE_RETURN_IF_ERROR(run.progress.check("comparing"));
  return update;
}

}  // namespace roomwise::pipeline
