#include "roomwise/pipeline/mapping/culling.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "roomwise/mapping/backend/frame_poses.h"
#include "roomwise/mapping/backend/keyframe_culling.h"
#include "roomwise/motion/view_agreement.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using geometry::RigidTransform;

constexpr std::array<std::pair<CullingVerdict, std::string_view>, 5> kVerdicts{
    {{CullingVerdict::kAddsNothing, "adds nothing"},
     {CullingVerdict::kNotFound, "not found by the walks before"},
     {CullingVerdict::kShowsMore, "shows what others do not"},
     {CullingVerdict::kRoomsPicture, "a picture of its room"},
     {CullingVerdict::kReferenced, "something hangs on it"}}};

// The first of each walk, by which a recording is known again, and of each component, in whose
// world the others lie; and where something hangs.
Expected<std::set<home::KeyframeId>> held_in(const home::Home& home,
                                             std::span<const home::Keyframe> keyframes) {
  ROOMWISE_TRY(auto held, home.held_keyframes());
  std::set<home::RecordingId> walks;
  std::set<std::uint64_t> components;
  for (const home::Keyframe& one : keyframes) {
    const bool begins_walk = walks.insert(one.recording).second;
    const bool begins_component = components.insert(one.pose.component).second;
    if (begins_walk || begins_component) held.insert(one.id);
  }
  return held;
}

// Where things stood or stand that some walk found changed, with the walks that tell of it.
struct ChangedPlace {
  Eigen::Vector3d middle_world;
  std::set<home::RecordingId> walks;
};
Expected<std::vector<ChangedPlace>> changed_places(const home::Home& home,
                                                   std::span<const home::Keyframe> keyframes) {
  ROOMWISE_TRY(const HomeHistory history, home_history_as_found(home));
  std::vector<ChangedPlace> places;
  const auto middle = [&](const objects::Instance& one) {
    return one.box_world(keyframes[one.keyframe_id].pose.world_from_keyframe).center();
  };
  for (const ThingHistory& one : history.things) {
    std::set<home::RecordingId> walks{one.first_seen.walk, one.last_seen.walk};
    bool is_changed = false;
    for (const WalkEvent& event : one.events) {
      if (!is_change(event.what)) continue;
      is_changed = true;
      walks.insert(event.walk);
      if (event.from) places.push_back({middle(*event.from), {one.first_seen.walk, event.walk}});
    }
    if (is_changed) places.push_back({middle(one.thing), walks});
  }
  return places;
}

// Judges the key-frames of one walk. The localiser answers for the home as it was before the walk,
// without walks that are taken away, whose pictures go when they are erased.
class KeyframeJudge {
 public:
  static Expected<KeyframeJudge> create(const home::Home& home, home::RecordingId walk,
                                        const CullingOptions& options, RunContext& run) {
    ROOMWISE_TRY(HomeLocalizer localizer, HomeLocalizer::create(home, {}, run));
    KeyframeJudge judge(std::move(localizer), options);
    ROOMWISE_TRY(judge.keyframes_, home.keyframes());
    ROOMWISE_TRY(judge.placed_, map_keyframes(home));
    ROOMWISE_TRY(judge.cameras_, recording_cameras(home));
    ROOMWISE_TRY(judge.rooms_, rooms_of_keyframes(home));
    ROOMWISE_TRY(judge.held_, held_in(home, judge.keyframes_));
    ROOMWISE_TRY(auto changed, changed_places(home, judge.keyframes_));
    for (ChangedPlace& place : changed) {
      if (place.walks.contains(walk)) judge.changed_.push_back(place.middle_world);
    }
    ROOMWISE_TRY(const auto edits, stored_edits(home));
    const std::set<home::RecordingId> taken = walks_taken_away(edits);
    for (const home::Keyframe& one : judge.placed_)
      judge.excluded_.push_back(one.recording >= walk || taken.contains(one.recording));
    judge.walk_ = walk;
    return judge;
  }

  [[nodiscard]] std::vector<std::size_t> candidates() const {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (placed_[i].recording == walk_) places.push_back(i);
    }
    return places;
  }
  [[nodiscard]] home::KeyframeId id_of(std::size_t place) const { return placed_[place].id; }
  [[nodiscard]] std::optional<Error> take_failure() const { return localizer_.take_failure(); }

  // Of a candidate. Thread-safe.
  [[nodiscard]] CullingVerdict judge(std::size_t place) const {
    const home::Keyframe& keyframe = placed_[place];
    if (held_.contains(keyframe.id) || shows_a_change(keyframe)) return CullingVerdict::kReferenced;
    const auto measured = localizer_.keyframe(place);
    if (!measured) return CullingVerdict::kReferenced;
    if (!is_seen_by_others(place, measured->measurements.view())) return CullingVerdict::kShowsMore;
    mapping::Query query{measured->measurements, cameras_.at(keyframe.recording), std::nullopt,
                         excluded_};
    for (int cover = 0; cover < options_.covers; ++cover) {
      const mapping::Localization answer = localizer_.localizer().locate(query);
      if (!is_right(answer, keyframe)) return CullingVerdict::kNotFound;
      if (!is_picture_of_room(keyframe.id, answer.keyframe)) return CullingVerdict::kRoomsPicture;
      const auto rested_on = std::ranges::find(placed_, answer.keyframe, &home::Keyframe::id);
      query.left_out[static_cast<std::size_t>(rested_on - placed_.begin())] = true;
    }
    return CullingVerdict::kAddsNothing;
  }

 private:
  KeyframeJudge(HomeLocalizer localizer, const CullingOptions& options)
      : localizer_(std::move(localizer)), options_(options) {}

  // The answer is certain by itself, and where the key-frame lies.
  [[nodiscard]] bool is_right(const mapping::Localization& answer,
                              const home::Keyframe& keyframe) const {
    if (!answer.found() || answer.is_weak_hypothesis) return false;
    const RigidTransform apart =
        keyframe.pose.world_from_keyframe.inverse() * answer.world_from_camera;
    return apart.distance_m() <= limits_.same_m && apart.angle_rad() <= limits_.same_rad;
  }

  // Rooms are learned from the pictures that were named.
  [[nodiscard]] bool is_picture_of_room(home::KeyframeId one, home::KeyframeId other) const {
    const auto named = rooms_.find(one);
    if (named == rooms_.end()) return true;
    const auto found = rooms_.find(other);
    return found != rooms_.end() && found->second == named->second;
  }

  // Whether the place of a thing that changed may be seen in it.
  [[nodiscard]] bool shows_a_change(const home::Keyframe& keyframe) const {
    constexpr double kFar_m = 5;
    const geometry::PinholeCamera& camera = cameras_.at(keyframe.recording);
    const RigidTransform keyframe_from_world = keyframe.pose.world_from_keyframe.inverse();
    return std::ranges::any_of(changed_, [&](const Eigen::Vector3d& middle_world) {
      const Eigen::Vector3d point = keyframe_from_world * middle_world;
      if (!(point.z() > 0) || point.norm() > kFar_m) return false;
      const Eigen::Vector2d pixel = camera.project(point);
      return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera.width &&
             pixel.y() < camera.height;
    });
  }

  // Whether others measured enough of what the picture measured (the share that the localiser calls
  // surely agreeing, each by as many others), and look through little of it.
  [[nodiscard]] bool is_seen_by_others(std::size_t place, const motion::RgbdPyramid& view) const {
    if (view.empty()) return false;
    const motion::PyramidLevel& level = motion::compared_level(view);
    const auto width = static_cast<std::size_t>(level.depth.width());
    std::vector<int> agreeing(width * static_cast<std::size_t>(level.depth.height()), 0);
    std::vector<bool> is_through(agreeing.size(), false);
    const RigidTransform& pose = placed_[place].pose.world_from_keyframe;
    std::size_t measured = 0;
    for (const std::size_t other : nearest(place)) {
      const auto seen = localizer_.keyframe(other);
      if (!seen || seen->measurements.view().empty()) continue;
      const motion::PyramidLevel& its = motion::compared_level(seen->measurements.view());
      measured = motion::for_each_correspondence(
          level, its, pose.inverse() * placed_[other].pose.world_from_keyframe,
          [&](const motion::Correspondence& one) {
            const auto depth = its.depth.at(one.column, one.row);
            if (depth == 0) return;
            const auto at =
                static_cast<std::size_t>(one.y) * width + static_cast<std::size_t>(one.x);
            const double behind_m = depth / its.camera.depth_units_per_metre - one.point.z();
            const double same_m = motion::same_surface_m(one.point.z());
            if (std::abs(behind_m) <= same_m) ++agreeing[at];
            if (behind_m > same_m) is_through[at] = true;
          });
    }
    const auto covered =
        std::ranges::count_if(agreeing, [&](int others) { return others >= options_.covers; });
    std::size_t through = 0;
    for (std::size_t at = 0; at < agreeing.size(); ++at)
      through += is_through[at] && agreeing[at] < options_.covers ? 1 : 0;
    const auto share = [&](auto count) {
      return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(measured, 1));
    };
    return share(covered) >= limits_.sure_agreeing &&
           share(through) <= limits_.max_confirmed_through;
  }

  // Key-frames of the walks before that may show the same, the nearest first; a metre counts as a
  // radian.
  [[nodiscard]] std::vector<std::size_t> nearest(std::size_t place) const {
    constexpr std::size_t kMax = 12;
    std::vector<std::pair<double, std::size_t>> near;
    const RigidTransform from_world = placed_[place].pose.world_from_keyframe.inverse();
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (excluded_[i]) continue;
      const RigidTransform apart = from_world * placed_[i].pose.world_from_keyframe;
      if (apart.distance_m() > limits_.place_m || apart.angle_rad() > limits_.place_rad) continue;
      near.emplace_back(apart.distance_m() + apart.angle_rad(), i);
    }
    std::ranges::sort(near);
    near.resize(std::min(near.size(), kMax));
    std::vector<std::size_t> places;
    for (const auto& [distance, at] : near) places.push_back(at);
    return places;
  }

  HomeLocalizer localizer_;
  CullingOptions options_;
  mapping::LocalizerOptions limits_;
  std::vector<home::Keyframe> keyframes_;  // by id
  std::vector<home::Keyframe> placed_;     // of the map
  std::vector<bool> excluded_;  // by place among those: of the walk, a later one, or one taken away
  home::RecordingId walk_ = 0;
  std::map<home::RecordingId, geometry::PinholeCamera> cameras_;
  KeyframeRooms rooms_;
  std::set<home::KeyframeId> held_;
  std::vector<Eigen::Vector3d> changed_;
};

struct Poses {
  std::vector<RigidTransform> world_from_keyframe;
  std::vector<TimestampNs> times_ns;
  std::vector<std::size_t> component;
};
Poses poses_of(std::span<const home::Keyframe> keyframes) {
  Poses poses;
  for (const home::Keyframe& one : keyframes) {
    poses.world_from_keyframe.push_back(one.pose.world_from_keyframe);
    poses.times_ns.push_back(one.timestamp_ns);
    poses.component.push_back(one.pose.component);
  }
  return poses;
}

// The key-frame that stays to which the frames of one that goes are anchored: the one before it on
// its walk, or the one after it, else the nearest of its component, whose first one stays.
home::KeyframeId anchor_of(home::KeyframeId id, std::span<const home::Keyframe> keyframes,
                           const std::set<home::KeyframeId>& culled) {
  const home::Keyframe& gone = keyframes[id];
  std::optional<home::KeyframeId> after, nearest;
  double nearest_m = 0;
  for (home::KeyframeId at = keyframes.size(); at-- > 0;) {
    const home::Keyframe& one = keyframes[at];
    if (culled.contains(at) || one.pose.component != gone.pose.component) continue;
    if (one.recording == gone.recording) {
      if (at < id) return at;
      after = at;
    }
    const double apart_m =
        (one.pose.world_from_keyframe.translation - gone.pose.world_from_keyframe.translation)
            .norm();
    if (!nearest || apart_m < nearest_m) {
      nearest = at;
      nearest_m = apart_m;
    }
  }
  return after.value_or(nearest.value_or(id));
}

// Frames whose place a key-frame told that goes, or the step to one that goes.
Expected<std::vector<home::KeyframeCulling::Place>> new_places(
    const home::Home& home, std::span<const home::Keyframe> keyframes, const Poses& poses,
    std::span<const mapping::PoseGraphEdge> edges, const std::set<home::KeyframeId>& culled) {
  std::vector<home::KeyframeCulling::Place> places;
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    const auto world_from_frame = mapping::frame_poses(
        frames, {poses.world_from_keyframe, poses.times_ns, poses.component}, edges);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!frames[i].place) continue;
      const home::KeyframeId id = frames[i].place->keyframe;
      if (!culled.contains(id) && !culled.contains(id + 1)) continue;
      const bool is_its_frame =
          keyframes[id].recording == recording.id && keyframes[id].frame_index == frames[i].index;
      if (is_its_frame && !culled.contains(id)) continue;
      const home::KeyframeId anchor = culled.contains(id) ? anchor_of(id, keyframes, culled) : id;
      places.push_back(
          {recording.id,
           frames[i].index,
           {anchor, poses.world_from_keyframe[anchor].inverse() * *world_from_frame[i]}});
    }
  }
  return places;
}

}  // namespace

Expected<void> CullingOptions::validate() const {
  if (covers < 1) return fail("covers = {} must be at least 1", covers);
  return {};
}

std::string_view to_string(CullingVerdict verdict) {
  return std::ranges::find(kVerdicts, verdict, &std::pair<CullingVerdict, std::string_view>::first)
      ->second;
}

std::vector<home::KeyframeId> redundant_of(const CullingVerdicts& verdicts) {
  std::vector<home::KeyframeId> ids;
  for (const auto& [id, verdict] : verdicts) {
    if (verdict == CullingVerdict::kAddsNothing) ids.push_back(id);
  }
  return ids;
}

Expected<CullingVerdicts> judge_keyframes(const home::Home& home, home::RecordingId walk,
                                          const CullingOptions& options, RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (std::ranges::find(recordings, walk, &home::StoredRecording::id) == recordings.end())
    return fail("{}: has no recording {}", home.file(), walk);
  ROOMWISE_TRY(const KeyframeJudge judge, KeyframeJudge::create(home, walk, options, run));
  const std::vector<std::size_t> candidates = judge.candidates();
  std::vector<CullingVerdict> verdicts(candidates.size());
  const std::size_t block = 4 * run.pool.size();
  run.progress.begin("judging key-frames", candidates.size());
  for (std::size_t first = 0; first < candidates.size(); first += block) {
    ROOMWISE_RETURN_IF_ERROR(run.progress.check("judging key-frames"));
    const std::size_t size = std::min(block, candidates.size() - first);
    run.pool.parallel_for(
        size, [&](std::size_t i) { verdicts[first + i] = judge.judge(candidates[first + i]); });
    run.progress.advance(first + size, "");
  }
  run.progress.end();
  if (auto failed = judge.take_failure()) return Unexpected(*std::move(failed));
  CullingVerdicts result;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    result[judge.id_of(candidates[i])] = verdicts[i];
  return result;
}

Expected<void> cull_keyframes(home::Home& home, const std::vector<home::KeyframeId>& culled,
                              const MapSettings& settings,
                              const std::shared_ptr<LostPictures>& lost) {
  if (culled.empty()) return {};
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const std::set<home::KeyframeId> ids(culled.begin(), culled.end());
  if (*ids.rbegin() >= keyframes.size())
    return fail("{}: has no key-frame {}", home.file(), *ids.rbegin());
  ROOMWISE_TRY(const auto held, held_in(home, keyframes));
  for (const home::KeyframeId id : ids) {
    if (held.contains(id))
      return fail("{}: key-frame {} cannot be taken out: something hangs on it", home.file(), id);
  }
  const Poses poses = poses_of(keyframes);
  ROOMWISE_TRY(const mapping::PoseGraph solved, stored_pose_graph(home, settings.solver));
  std::vector<mapping::PoseGraphEdge> edges = solved.edges;
  ROOMWISE_TRY(const auto measured, home.edges());
  // What may join components later stays, too.
  std::ranges::copy_if(measured, std::back_inserter(edges), [&](const auto& edge) {
    return poses.component[edge.from] != poses.component[edge.to];
  });
  std::vector<std::size_t> walk;
  for (const home::Keyframe& one : keyframes)
    walk.push_back(static_cast<std::size_t>(one.recording));
  home::KeyframeCulling culling;
  culling.culled.assign(ids.begin(), ids.end());
  culling.edges = mapping::edges_without({poses.world_from_keyframe, poses.component, walk, edges},
                                         culling.culled);
  ROOMWISE_TRY(culling.places, new_places(home, keyframes, poses, solved.edges, ids));
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(auto index, take_localizer_index(home));
    ROOMWISE_RETURN_IF_ERROR(home.cull_keyframes(culling));
    if (index) ROOMWISE_RETURN_IF_ERROR(keep_localizer_index_without(home, *std::move(index), ids));
    return update_objects(home, settings.objects, lost).map([](const FoundObjects&) {});
  });
}

}  // namespace roomwise::pipeline
