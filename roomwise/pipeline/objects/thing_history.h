#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/instances/instances.h"
#include "roomwise/pipeline/objects/home_things.h"

// What became of the things of a home from walk to walk: objects::find_changes() told of one walk
// after the other, the walk's key-frames as the visit and those of the walks before it as the map.
namespace roomwise::pipeline {

enum class ThingEvent {
  kFound,       // the first walk that shows its place found it there
  kNew,         // came: the walks before show its place without it
  kThere,       // stood where it was
  kMoved,       // stood elsewhere
  kShifted,     // was pushed or turned, and not found again
  kGone,        // stood there no more
  kUnobserved,  // the walk did not show enough of its place to say
};
// "found", "new", "there", "moved", "shifted", "gone", "not looked at".
[[nodiscard]] std::string_view to_string(ThingEvent event);
// Whether the home is another than before: new, moved, shifted or gone.
[[nodiscard]] bool is_change(ThingEvent event);

struct WalkEvent {
  home::RecordingId walk = 0;
  ThingEvent what = ThingEvent::kThere;
  // Of what moved: as it stood before.
  std::optional<objects::Instance> from = std::nullopt;
};

// A moment of a walk, in the time of its recording.
struct Sighting {
  home::RecordingId walk = 0;
  TimestampNs time_ns = 0;

  friend bool operator==(const Sighting&, const Sighting&) = default;
};

struct ThingHistory {
  objects::Instance thing;  // as it stands or, where it is gone, as it stood; without its surface
  bool is_gone = false;
  Sighting first_seen, last_seen;
  std::vector<WalkEvent> events;  // one a walk, from the one on that found it

  // The thing; where it was only shifted, less surely there.
  [[nodiscard]] objects::Instance as_it_stands() const;
  // Whether the last walk that looked at its place found it pushed or turned.
  [[nodiscard]] bool was_shifted_last() const;
};

// How far a thing stood away after an event from where it stood before, m, by the poses of the
// home's key-frames, which lie by id; absent where it did not move. `event`: one of thing.events.
[[nodiscard]] std::optional<double> moved_m(const ThingHistory& thing, const WalkEvent& event,
                                            std::span<const home::Keyframe> keyframes);

// What a walk changed; both of a HomeHistory, which must outlive it.
struct ThingChange {
  const ThingHistory* thing = nullptr;
  const WalkEvent* event = nullptr;  // of the thing
};

struct HomeHistory {
  // The walks that have joined the map, in the order of time where all their stamps tell the date,
  // else as they were mapped.
  std::vector<home::RecordingId> walks;
  // Those that are there in the order of the home's instances, then those that are gone.
  std::vector<ThingHistory> things;

  // Of an instance of the home; nullptr where it is none that walks show: a later visit brought it,
  // or somebody added it by hand.
  [[nodiscard]] const ThingHistory* of(const objects::Instance& instance) const;
  // In the order of things.
  [[nodiscard]] std::vector<ThingChange> changes_by(home::RecordingId walk) const;
  // By the home's things: what somebody renamed is called so, also when it is gone, and what
  // somebody took out, or stands there and is among them no more since a visit found it gone, is
  // left out.
  void correct(const HomeThings& corrections);
};

// The walks of the map's largest component, as HomeHistory::walks.
[[nodiscard]] Expected<std::vector<home::RecordingId>> walks_in_order(const home::Home& home);

// Joins what finders saw in the key-frames of all walks into things, and follows them from walk to
// walk:
//
// 1. The things of the walks so far (objects::find_instances of all their key-frames) are compared
//    with those of the next walk alone (objects::find_changes).
// 2. What is gone or moved is taken out of what the earlier walks saw, so that a place that is
//    empty now, or has something else in it, gives no instance.
// 3. What is left of the earlier walks and all of the next one are joined anew: what stands still
//    is the surer the more walks show it.
//
// So of one walk the things are those of find_instances(), to the bit. Of components that nothing
// joined each is a home of its own. Reads only; the same home gives the same.
[[nodiscard]] Expected<HomeHistory> follow_things(const home::Home& home);

// As the home keeps it or, where that is missing, damaged or of other key-frames, poses or looks of
// finders, by follow_things().
[[nodiscard]] Expected<HomeHistory> home_history_as_found(const home::Home& home);
// The same, then corrected by its things.
[[nodiscard]] Expected<HomeHistory> find_home_history(const home::Home& home);
[[nodiscard]] Expected<HomeHistory> find_home_history(const home::Home& home,
                                                      const HomeThings& things);
// Makes it anew where find_home_history() would, and keeps it in the home, as derived data.
[[nodiscard]] Expected<void> keep_home_history(home::Home& home);
[[nodiscard]] Expected<void> keep_home_history(home::Home& home, const HomeHistory& history);

}  // namespace roomwise::pipeline
