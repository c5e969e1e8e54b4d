#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/questions/home_prompts.h"
#include "roomwise/guide/way/plan.h"
#include "roomwise/home/home.h"
#include "roomwise/live/view/live_map.h"
#include "roomwise/pipeline/edits/marked_spots.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/objects/own_things.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::live {

struct ViewedWalk {
  home::StoredRecording stored;
  std::size_t keyframes = 0;
  recording::RoomLabels labels;
};

struct ViewedKeyframe {
  home::Keyframe keyframe;
  std::string room;  // as the helper named it; empty: not named
  bool on_map = false;
};

// What the newest walk changed of what the walks before it had shown.
struct ViewedChange {
  std::string what;  // "new", "moved", "shifted" or "gone"
  std::string name;
  std::optional<std::string> room;  // where it stands now or, gone, stood
  std::optional<double> moved_m;
};
struct ViewedChanges {
  home::RecordingId walk = 0, since = 0;  // the newest walk of the map, and the one before it
  std::vector<ViewedChange> things;
};

// By what picture shows an instance best, and where in it: the same as long as the thing is,
// whatever it is called and whichever others come and go. Positive, at most 2^53.
[[nodiscard]] std::int64_t thing_id(const objects::Instance& instance);
// The same; of what a helper added, and no picture shows, by the change that did.
[[nodiscard]] std::int64_t thing_id(const pipeline::HomeThing& thing);
[[nodiscard]] std::int64_t thing_id(const guide::KnownThing& thing);

// A change that a helper made, and whether it holds.
struct ViewedEdit {
  pipeline::StoredEdit edit;
  std::string without_effect;  // why nothing comes of it at present; empty: it holds
  std::string why_not_undone;  // what must be undone first; empty: nothing
};

// A thing that somebody taught.
struct ViewedOwnThing {
  home::OwnThing stored;
  guide::KnownThing thing;  // where it was seen last
};

// A place that somebody marked, or where they set out.
struct ViewedSpot {
  pipeline::MarkedSpot stored;
  guide::KnownThing thing;  // where it is, as far as that is known; called as it is asked for
};

// All that is told of a home, at one moment: values that never change.
struct HomeView {
  std::string name;
  std::vector<rooms::Room> rooms;  // by name
  // As found and as helpers changed them; without a place until the map is ready.
  std::vector<guide::KnownThing> things;
  std::vector<ViewedEdit> edits;  // that helpers made, the newest first
  // What the last visit or the last of several walks changed: the later of the two by their stamps
  // or, where these do not tell the date, the walk. All but what is gone are among things.
  guide::ChangedThings latest;
  std::vector<ViewedWalk> walks;  // as stored
  // What people taught, whoever may be told of it; not among things but in the view of who may.
  std::vector<ViewedOwnThing> own_things;
  // All that people marked; and of these, in the view of who may be told, those that they may name,
  // with where they set out when they were last led somewhere.
  std::vector<ViewedSpot> marked, spots;
  // Looks for taught things in pictures; null where there are none, or what is usual is not known.
  std::shared_ptr<const pipeline::OwnThingWatch> own_thing_watch;
  // Absent where the map is of one walk, or nothing was found on it.
  std::optional<ViewedChanges> changes;
  std::vector<ViewedKeyframe> keyframes;  // by id
  std::vector<std::string> room_types;    // of the concepts, by name
  rooms::Concepts concepts;
  std::string learned_report;  // JSON; empty: nothing was learned
  std::string learned_network;
  std::optional<rooms::RoomLayout> layout;  // where rooms are named and the map shows a floor
  std::shared_ptr<const LiveMap> map;       // null until it is ready
  // Null where no rooms were learned, or not with a network at hand: then why.
  std::shared_ptr<const pipeline::RoomRecognizer> recognizer;
  std::string why_no_recognizer;

  // What was forgotten and could not be erased from the file yet.
  bool owes_erasing = false;
  // Walks that are not shown any more, though they are in the home until it is closed.
  [[nodiscard]] std::set<home::RecordingId> walks_taken_away() const;
  // The room that a point lies in by the layout.
  [[nodiscard]] std::optional<std::string> room_at(const Eigen::Vector3d& point_plan) const;
  // The room that a point, known with this standard deviation, most probably lies in, and how
  // probable that is. Where the map shows no floor, the one whose name the walks have all about it.
  [[nodiscard]] std::optional<rooms::RoomScore> room_around(const Eigen::Vector3d& point_plan,
                                                            double sigma_m) const;
};

// A spot as the view's map and rooms have its place. `name`: as it is asked for.
[[nodiscard]] ViewedSpot view_spot(const pipeline::MarkedSpot& spot, const std::string& name,
                                   const HomeView& view);
// Takes them from the home anew.
[[nodiscard]] Expected<void> view_spots(const home::Home& home, HomeView& view);

// Where its rooms meet; none where rooms or a floor are not known.
[[nodiscard]] std::vector<rooms::Doorway> doorways_of(const HomeView& home);
// What it points to are the home and the doorways: they must outlive it.
[[nodiscard]] guide::HomeMap map_of(const HomeView& home, std::span<const rooms::Doorway> doorways);

// `networks` must outlive the view; `map` may be null.
[[nodiscard]] Expected<std::shared_ptr<const HomeView>> view_home(
    const home::Home& home, const pipeline::Networks& networks, std::shared_ptr<const LiveMap> map,
    std::shared_ptr<const pipeline::OwnThingWatch> own_thing_watch = nullptr);

}  // namespace roomwise::live
