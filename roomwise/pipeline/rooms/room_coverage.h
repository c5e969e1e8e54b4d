#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/rooms/floor_gaps.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/rooms/learning/room_learner.h"

// What the walks of a home have not shown yet: where the helper should walk once more.
namespace roomwise::pipeline {

// How the pictures look that one walk took of one room. A camera's own exposure and white balance
// take away much of what the light does, so this tells that two walks differ, and not which of them
// was by day.
struct RoomLight {
  // Median, lower and upper quartile of the pictures' mean brightness, 0 to 1.
  double brightness = 0, brightness_low = 0, brightness_high = 0;
  // The same of red over blue: lamps give more of it than the day.
  double red_over_blue = 1, red_over_blue_low = 1, red_over_blue_high = 1;

  // Whether the medians of one of both are farther apart than the middle half of either walk's
  // pictures.
  [[nodiscard]] bool differs_from(const RoomLight& other) const;
};

// How light one picture is.
struct PictureTone {
  double brightness = 0;     // mean, 0 to 1
  double red_over_blue = 1;  // of the means
};
// By key-frame and its time: who keeps them looks at no picture twice.
using PictureTones = std::map<std::pair<home::KeyframeId, TimestampNs>, PictureTone>;

// A room as one walk saw it.
struct RoomOnWalk {
  home::RecordingId walk = 0;
  std::size_t pictures =
      0;  // key-frames that are kept; 0: others show in the same light what it did
  TimestampNs first_ns = 0, last_ns = 0;
  std::optional<RoomLight> light;  // absent where there are no pictures, or they are sealed
};

struct RoomSeen {
  std::string room;
  std::vector<RoomOnWalk> walks;  // as they were mapped
  // That it was learned from, photos and what was culled since among them; 0: it was not.
  std::size_t learned_pictures = 0;

  [[nodiscard]] std::size_t pictures() const;
  // Whether a walk through it brought no picture that was kept: in that light the map has it all.
  [[nodiscard]] bool is_shown_whole() const;
  // Whether two walks saw it by different light; absent where that is not known.
  [[nodiscard]] std::optional<bool> by_several_lights() const;
};

struct CoverageOptions {
  rooms::LearningOptions learning;  // how many pictures of a room learning needs
  FloorGapOptions floor;
  std::set<home::RecordingId> without;  // walks whose pictures count for nothing

  [[nodiscard]] Expected<void> validate() const;
};

struct RoomCoverage {
  std::vector<home::StoredRecording> walks;   // as they were mapped
  std::vector<home::RecordingId> not_joined;  // walks of which nothing lies on the map
  std::vector<std::size_t> unnamed;           // of each walk: key-frames that nobody named
  std::vector<RoomSeen> rooms;                // by name
  std::vector<FloorGap> gaps;                 // the longest first
  bool knows_floor = false;                   // the map shows where the named rooms lie
};

// Looks at the home's key-frames but for those that are `known`, which takes a moment, and at its
// floor; known is then what it looked at. Fails where an image cannot be read, and when the user
// interrupts.
[[nodiscard]] Expected<RoomCoverage> find_room_coverage(const home::Home& home,
                                                        const CoverageOptions& options,
                                                        RunContext& run, PictureTones& known);
[[nodiscard]] Expected<RoomCoverage> find_room_coverage(const home::Home& home,
                                                        const CoverageOptions& options,
                                                        RunContext& run);

// What is missing, the one kind before the other as the helper should mend it.
enum class Missing {
  kJoin,          // a walk that has not joined the map
  kNames,         // pictures of a walk that no room has
  kPictures,      // of a room there are too few to learn it
  kMorePictures,  // enough to learn it, and few to know it well
  kSecondWalk,    // only one walk saw the room
  kOtherLight,    // all walks saw it by one light
  kFloor,         // a FloorGap
};
[[nodiscard]] std::string_view to_string(Missing what);  // "join", "names", ...

struct CoverageItem {
  Missing what = Missing::kJoin;
  std::string room;                       // empty: of no room
  std::optional<home::RecordingId> walk;  // that it is about
  std::size_t pictures = 0;               // that there are
  std::optional<FloorGap> gap;
};
[[nodiscard]] std::vector<CoverageItem> missing_items(const RoomCoverage& coverage,
                                                      const CoverageOptions& options);

}  // namespace roomwise::pipeline
