#pragma once

#include <functional>
#include <string>
#include <vector>

#include "command.h"
#include "home/walk_words.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::app {

// What became of a home's things from walk to walk, in words and in JSON.
class HistoryWords {
 public:
  [[nodiscard]] static Expected<HistoryWords> of(const home::Home& home);

  [[nodiscard]] const pipeline::HomeHistory& history() const { return history_; }
  [[nodiscard]] const WalkWords& walks() const { return walks_; }
  // "chair, kitchen: found by monday; there on tuesday; moved by 1.2 m, from the lounge, on
  // friday".
  [[nodiscard]] std::string line(const pipeline::ThingHistory& thing) const;
  // What a walk changed, a line each: "chair moved by 1.2 m, from the lounge to the kitchen".
  [[nodiscard]] std::vector<std::string> changes(home::RecordingId walk) const;
  // {"what", "name", "room", "moved_m", "room_before"} each.
  [[nodiscard]] Json changes_json(home::RecordingId walk) const;
  // {"walk", "time_s", "date"}.
  [[nodiscard]] Json sighting_json(const pipeline::Sighting& seen) const;
  // {"walk", "what", "moved_m", "room_before"} each.
  [[nodiscard]] Json events_json(const pipeline::ThingHistory& thing) const;
  // That the thing stands in; empty: not known.
  [[nodiscard]] std::string room(const pipeline::ThingHistory& thing) const;
  // By `room_of`, which must outlive it; else as the helper named it where a thing is seen best.
  using RoomOf = std::function<std::string(const pipeline::HomeThing&)>;
  void place_by(RoomOf room_of) { room_of_ = std::move(room_of); }

 private:
  [[nodiscard]] std::string room(const pipeline::HomeThing& thing) const;
  [[nodiscard]] std::string room_before(const pipeline::WalkEvent& event) const;
  [[nodiscard]] Json event_json(const pipeline::ThingHistory& thing,
                                const pipeline::WalkEvent& event) const;

  pipeline::HomeHistory history_;
  WalkWords walks_;
  std::vector<home::Keyframe> keyframes_;
  pipeline::KeyframeRooms rooms_;
  std::vector<pipeline::HomeThing> things_;  // as people corrected them
  RoomOf room_of_;
};

}  // namespace roomwise::app
