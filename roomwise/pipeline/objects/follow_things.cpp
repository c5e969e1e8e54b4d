#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "roomwise/base/calendar_time.h"
#include "roomwise/objects/changes/changes.h"
#include "roomwise/pipeline/objects/stored_detections.h"
#include "roomwise/pipeline/objects/thing_history.h"

namespace roomwise::pipeline {
namespace {

using objects::ChangeState;
using objects::ObservedKeyframe;
using objects::PlacedInstance;

// Instances with their places in the world and the key-frames that show them.
struct JoinedThings {
  std::vector<objects::Instance> instances;
  std::vector<PlacedInstance> placed;
  std::vector<std::vector<std::size_t>> supporting;  // places in the key-frames, ascending
};
JoinedThings join_things(std::span<const ObservedKeyframe> keyframes,
                         const objects::GroundPlane& level) {
  JoinedThings joined;
  joined.instances = objects::find_instances(keyframes, level, {});
  std::map<home::KeyframeId, const ObservedKeyframe*> by_id;
  for (const ObservedKeyframe& one : keyframes) by_id[one.keyframe_id] = &one;
  for (const objects::Instance& one : joined.instances) {
    joined.placed.push_back(
        objects::placed_instance(one, one.box_world(by_id.at(one.keyframe_id)->world_from_camera),
                                 keyframes, level, &joined.supporting.emplace_back()));
  }
  return joined;
}

std::vector<objects::DepthView> depth_views(std::span<const ObservedKeyframe> keyframes) {
  std::vector<objects::DepthView> views;
  for (const ObservedKeyframe& one : keyframes) {
    views.push_back(
        {one.world_from_camera, &one.camera, &one.coarse_depth, objects::kCoarseDepthStep_px});
  }
  return views;
}

// A walk has some five times fewer key-frames than a visit has pictures. What is gone goes from the
// list of things, so most of its whole surface must be looked through, not of a part that a few
// show. Not fitted: these were chosen by looking at the two homes that docs/objects.md measures
// them on. What decides between gone and there over walks is to be fitted as of visits, on homes of
// its own.
objects::ChangeOptions change_options() {
  objects::ChangeOptions options;
  options.min_decided = options.min_gone;
  options.of_whole_surface = true;
  return options;
}

ThingEvent event_of(ChangeState state) {
  switch (state) {
    case ChangeState::kThere:
      return ThingEvent::kThere;
    case ChangeState::kMoved:
      return ThingEvent::kMoved;
    case ChangeState::kShifted:
      return ThingEvent::kShifted;
    case ChangeState::kRemoved:
      return ThingEvent::kGone;
    case ChangeState::kUnobserved:
      break;
  }
  return ThingEvent::kUnobserved;
}

// Follows the things of one component of the map.
class ThingFollower {
 public:
  ThingFollower(std::span<const home::Keyframe> keyframes, const objects::GroundPlane& level)
      : keyframes_(keyframes), level_(level) {}

  // The key-frames of the next walk that finders looked at.
  void follow(home::RecordingId walk, std::vector<ObservedKeyframe> own) {
    if (own.empty()) return;
    if (seen_.empty()) {
      add_seen(walk, std::move(own));
      take_joined(walk, 0, {});
      return;
    }
    JoinedThings now = join_things(own, level_);
    const auto views_now = depth_views(own);
    for (std::size_t i = 0; i < now.placed.size(); ++i) {
      if (!now.supporting[i].empty()) keep_what_stands(now.placed[i], views_now);
    }
    std::vector<std::size_t> standing;  // in followed_
    std::vector<PlacedInstance> before, past;
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      const Followed& one = followed_[i];
      if (one.history.is_gone) {
        past.push_back({one.placed.name, one.placed.box_world, {}});
      } else {
        standing.push_back(i);
        before.push_back(one.placed);
      }
      past.insert(past.end(), one.earlier_places.begin(), one.earlier_places.end());
    }
    const objects::Changes changes =
        objects::find_changes(before, views_, now.placed, views_now, past, change_options());
    const WalkLook look{walk, own, views_now};
    for (std::size_t at = 0; at < standing.size(); ++at) {
      judge(followed_[standing[at]], changes.before[at], now, look);
    }
    std::vector<PlacedInstance> arrived;
    for (const objects::ArrivedInstance& one : changes.arrived)
      arrived.push_back(now.placed[one.now]);
    const std::size_t first_of_walk = seen_.size();
    add_seen(walk, std::move(own));
    take_joined(walk, first_of_walk, arrived);
  }

  // In the order of their instances, then those that are gone.
  [[nodiscard]] std::vector<ThingHistory> histories() && {
    std::ranges::stable_sort(followed_, {}, [](const Followed& one) {
      return std::pair(one.history.is_gone, one.history.is_gone ? std::size_t{0} : one.place);
    });
    std::vector<ThingHistory> histories;
    for (Followed& one : followed_) histories.push_back(std::move(one.history));
    return histories;
  }

 private:
  struct Followed {
    ThingHistory history;
    PlacedInstance placed;                       // as it stands now, or stood
    std::vector<PlacedInstance> earlier_places;  // from where it was moved away
    std::size_t place = 0;                       // of the instance among those joined last
  };

  // What a walk looked at, by itself.
  struct WalkLook {
    home::RecordingId walk = 0;
    std::span<const ObservedKeyframe> keyframes;
    std::span<const objects::DepthView> views;  // of these
  };

  void add_seen(home::RecordingId walk, std::vector<ObservedKeyframe> own) {
    places_of_walk_[walk] = {seen_.size(), own.size()};
    std::ranges::move(own, std::back_inserter(seen_));
    views_ = depth_views(seen_);  // all of them: the key-frames may lie elsewhere now
    for (std::size_t i = seen_.size() - own.size(); i < seen_.size(); ++i)
      place_of_[seen_[i].keyframe_id] = i;
  }
  [[nodiscard]] home::RecordingId walk_of(std::size_t place) const {
    return keyframes_[seen_[place].keyframe_id].recording;
  }

  [[nodiscard]] Sighting sighting(home::RecordingId walk, const ObservedKeyframe& one) const {
    return {walk, keyframes_[one.keyframe_id].timestamp_ns};
  }

  // What a further walk says of a thing that stood when it began.
  void judge(Followed& one, const objects::InstanceChange& change, const JoinedThings& now,
             const WalkLook& look) {
    WalkEvent& event =
        one.history.events.emplace_back(WalkEvent{look.walk, event_of(change.state)});
    if (event.what == ThingEvent::kUnobserved) return;
    if (event.what == ThingEvent::kThere || event.what == ThingEvent::kShifted) {
      note_last_view(one, look);
    }
    if (event.what == ThingEvent::kShifted) {
      // The next walk is asked for what is left there.
      one.placed.surface_world = objects::remaining_surface(one.placed.surface_world, look.views);
    }
    if (event.what != ThingEvent::kGone && event.what != ThingEvent::kMoved) return;
    take_out(one);
    if (event.what == ThingEvent::kGone) {
      one.history.is_gone = true;
      return;
    }
    event.from = one.history.thing;
    one.earlier_places.push_back({one.placed.name, one.placed.box_world, {}});
    one.placed = now.placed[*change.now];
  }

  // The last picture of the walk that shows the thing's surface.
  void note_last_view(Followed& one, const WalkLook& look) const {
    for (std::size_t i = look.views.size(); i-- > 0;) {
      const auto evidence =
          objects::surface_evidence(one.placed.surface_world, look.views.subspan(i, 1));
      if (evidence.views == 0 || 2 * evidence.gone > evidence.decided) continue;
      one.history.last_seen = sighting(look.walk, look.keyframes[i]);
      return;
    }
  }

  // Out of what the walks so far saw, what they saw of a thing that is there no more.
  void take_out(const Followed& one) {
    constexpr double kSlack_m = 0.05;
    const auto shows_it = [&](const ObservedKeyframe& keyframe, const objects::Detection& shown) {
      const std::string& name = shown.class_name;
      if (name != one.history.thing.name && !one.history.thing.names.contains(name)) return false;
      const auto& points = shown.surface.points;
      const auto inside = std::ranges::count_if(points, [&](const Eigen::Vector3f& point) {
        return one.placed.box_world.distance_m(keyframe.world_from_camera * point.cast<double>()) <=
               kSlack_m;
      });
      return inside > 0 && 2 * static_cast<std::size_t>(inside) >= points.size();
    };
    for (ObservedKeyframe& keyframe : seen_) {
      std::erase_if(keyframe.detections,
                    [&](const objects::Detection& shown) { return shows_it(keyframe, shown); });
    }
  }

  // Of a thing's surface, what the walk that saw it last does not look through itself: what depth
  // measured at its rim, or behind it, would be gone on every later walk.
  static void keep_what_stands(PlacedInstance& thing, std::span<const objects::DepthView> walk) {
    thing.surface_world = objects::remaining_surface(thing.surface_world, walk);
  }

  // Joins what is left of all walks so far anew, and gives each instance to the thing that it is.
  // `first_of_walk`: from there on the key-frames are the newest walk's.
  void take_joined(home::RecordingId walk, std::size_t first_of_walk,
                   std::span<const PlacedInstance> arrived) {
    JoinedThings joined = join_things(seen_, level_);
    for (std::size_t j = 0; j < joined.placed.size(); ++j) {
      if (joined.supporting[j].empty()) continue;
      const auto [first, count] = places_of_walk_.at(walk_of(joined.supporting[j].back()));
      keep_what_stands(joined.placed[j], std::span(views_).subspan(first, count));
    }
    std::vector<std::size_t> standing;
    std::vector<PlacedInstance> places;
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      if (followed_[i].history.is_gone) continue;
      standing.push_back(i);
      places.push_back(followed_[i].placed);
    }
    std::vector<std::optional<std::size_t>> thing_of(joined.instances.size());  // in followed_
    std::set<std::size_t> lost(standing.begin(), standing.end());
    const auto matches = objects::match_by_name_and_place(places, joined.placed);
    for (std::size_t at = 0; at < standing.size(); ++at) {
      if (!matches[at]) continue;
      thing_of[*matches[at]] = standing[at];
      lost.erase(standing[at]);
    }
    std::set<std::size_t> is_new;
    for (const auto& match : objects::match_by_name_and_place(arrived, joined.placed)) {
      if (match) is_new.insert(*match);
    }
    const auto newest = std::span(views_).subspan(first_of_walk);
    for (std::size_t j = 0; j < joined.instances.size(); ++j) {
      if (thing_of[j]) {
        take(followed_[*thing_of[j]], joined, j);
      } else if (!is_empty_now(joined, j, first_of_walk, newest)) {
        begin(walk, joined, j, is_new.contains(j));
      }
    }
    // All walks together call it otherwise, or believe in it no more: then it is none of the home's
    // things, and was not one.
    for (auto one = lost.rbegin(); one != lost.rend(); ++one) {
      followed_.erase(followed_.begin() + static_cast<std::ptrdiff_t>(*one));
    }
  }

  // Whether the newest walk looks through where only earlier ones saw something.
  static bool is_empty_now(const JoinedThings& joined, std::size_t j, std::size_t first_of_walk,
                           std::span<const objects::DepthView> newest) {
    if (first_of_walk == 0) return false;
    const auto& supporting = joined.supporting[j];
    if (!supporting.empty() && supporting.back() >= first_of_walk) return false;
    const objects::ChangeOptions options = change_options();
    const auto evidence = objects::surface_evidence(joined.placed[j].surface_world, newest);
    return evidence.decided_share() >= options.min_decided && evidence.views >= options.min_views &&
           evidence.gone_share_of_whole() >= options.min_gone;
  }

  void take(Followed& one, const JoinedThings& joined, std::size_t j) {
    const bool was_shifted = one.history.was_shifted_last();
    std::vector<Eigen::Vector3f> remaining = std::move(one.placed.surface_world);
    one.placed = joined.placed[j];
    if (was_shifted) one.placed.surface_world = std::move(remaining);
    one.place = j;
    one.history.thing = joined.instances[j];
    note_support(one, joined, j);
  }

  void begin(home::RecordingId walk, const JoinedThings& joined, std::size_t j, bool is_new) {
    Followed& one = followed_.emplace_back();
    one.place = j;
    one.placed = joined.placed[j];
    one.history.thing = joined.instances[j];
    const std::size_t best = place_of_.at(joined.instances[j].keyframe_id);
    one.history.first_seen = one.history.last_seen = sighting(walk_of(best), seen_[best]);
    note_support(one, joined, j);
    one.history.events.push_back({walk, is_new ? ThingEvent::kNew : ThingEvent::kFound});
  }

  // First and last by the key-frames that show it, in the order of walks.
  void note_support(Followed& one, const JoinedThings& joined, std::size_t j) const {
    const auto& supporting = joined.supporting[j];
    if (supporting.empty()) return;
    const auto at = [&](std::size_t place) { return sighting(walk_of(place), seen_[place]); };
    const bool begins = one.history.events.empty();
    if (begins) one.history.first_seen = at(supporting.front());
    const Sighting last = at(supporting.back());
    const bool is_of_newest = last.walk == walk_of(seen_.size() - 1);
    if (begins || (is_of_newest && (last.walk != one.history.last_seen.walk ||
                                    last.time_ns > one.history.last_seen.time_ns))) {
      one.history.last_seen = last;
    }
    // Depth did not decide, but the walk's own pictures show it there.
    if (begins) return;
    WalkEvent& newest = one.history.events.back();
    if (newest.walk == last.walk && newest.what == ThingEvent::kUnobserved)
      newest.what = ThingEvent::kThere;
  }

  std::span<const home::Keyframe> keyframes_;  // by id
  const objects::GroundPlane& level_;
  std::vector<ObservedKeyframe> seen_;     // of the walks so far, without what is there no more
  std::vector<objects::DepthView> views_;  // of these
  std::map<home::KeyframeId, std::size_t> place_of_;  // in seen_
  // Of each walk its first place in seen_, and how many it has there.
  std::map<home::RecordingId, std::pair<std::size_t, std::size_t>> places_of_walk_;
  std::vector<Followed> followed_;
};

}  // namespace

Expected<std::vector<home::RecordingId>> walks_in_order(const home::Home& home) {
  struct Walk {
    home::RecordingId id;
    TimestampNs first_ns;
  };
  std::vector<Walk> walks;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& one : keyframes) {  // by id: walk after walk as they were mapped
    if (one.pose.component != 0) continue;
    const bool is_known =
        std::ranges::any_of(walks, [&](const Walk& walk) { return walk.id == one.recording; });
    if (!is_known) walks.push_back({one.recording, one.timestamp_ns});
  }
  const auto tells_date = [](const Walk& walk) { return calendar_time(walk.first_ns).has_value(); };
  if (std::ranges::all_of(walks, tells_date)) std::ranges::stable_sort(walks, {}, &Walk::first_ns);
  std::vector<home::RecordingId> ids;
  for (const Walk& walk : walks) ids.push_back(walk.id);
  return ids;
}

Expected<HomeHistory> follow_things(const home::Home& home) {
  HomeHistory history;
  ROOMWISE_TRY(auto components, observed_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(history.walks, walks_in_order(home));
  std::vector<ThingHistory> gone;
  for (auto& [component, looked] : components) {
    const objects::GroundPlane level = objects::fit_ground_plane(looked);
    std::map<home::RecordingId, std::vector<ObservedKeyframe>> of_walk;
    std::vector<home::RecordingId> order = history.walks;
    for (ObservedKeyframe& one : looked) {
      const home::RecordingId walk = keyframes[one.keyframe_id].recording;
      if (component != 0 && !of_walk.contains(walk)) order.push_back(walk);
      of_walk[walk].push_back(std::move(one));
    }
    if (component != 0) order.erase(order.begin(), order.begin() + std::ssize(history.walks));
    ThingFollower follower(keyframes, level);
    for (const home::RecordingId walk : order) follower.follow(walk, std::move(of_walk[walk]));
    for (ThingHistory& one : std::move(follower).histories()) {
      (one.is_gone ? gone : history.things).push_back(std::move(one));
    }
  }
  std::ranges::move(gone, std::back_inserter(history.things));
  return history;
}

}  // namespace roomwise::pipeline
