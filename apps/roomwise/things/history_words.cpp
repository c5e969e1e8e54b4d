#include "things/history_words.h"

#include <algorithm>

#include "pose_json.h"

namespace roomwise::app {

using pipeline::ThingEvent;
using pipeline::ThingHistory;
using pipeline::WalkEvent;

Expected<HistoryWords> HistoryWords::of(const home::Home& home) {
  HistoryWords words;
  ROOMWISE_TRY(pipeline::HomeThings things, pipeline::find_home_things(home));
  ROOMWISE_TRY(words.history_, pipeline::find_home_history(home, things));
  words.things_ = std::move(things.things);
  ROOMWISE_TRY(words.walks_, WalkWords::of(home));
  ROOMWISE_TRY(words.keyframes_, home.keyframes());
  ROOMWISE_TRY(words.rooms_, pipeline::rooms_of_keyframes(home));
  return words;
}

namespace {

pipeline::HomeThing as_thing(const objects::Instance& instance) {
  pipeline::HomeThing thing;
  static_cast<objects::Instance&>(thing) = instance;
  return thing;
}

}  // namespace

std::string HistoryWords::room(const ThingHistory& thing) const {
  // Somebody may have put it elsewhere by hand.
  const auto corrected = std::ranges::find_if(
      things_, [&](const pipeline::HomeThing& one) { return history_.of(one) == &thing; });
  return room(corrected != things_.end() ? *corrected : as_thing(thing.thing));
}

std::string HistoryWords::room_before(const WalkEvent& event) const {
  return event.from ? room(as_thing(*event.from)) : std::string();
}

std::string HistoryWords::room(const pipeline::HomeThing& thing) const {
  if (room_of_) return room_of_(thing);
  const auto room = rooms_.find(thing.keyframe_id);
  return room == rooms_.end() ? std::string() : room->second;
}

std::string HistoryWords::line(const ThingHistory& thing) const {
  const std::string in = room(thing);
  std::string line = thing.thing.name + (in.empty() ? "" : ", " + in) + ":";
  for (const WalkEvent& event : thing.events) {
    const std::string& walk = walks_.name(event.walk);
    if (&event != &thing.events.front()) line += ";";
    if (event.what == ThingEvent::kUnobserved) {
      line += fmt::format(" not looked at by {}", walk);
    } else if (event.what == ThingEvent::kFound) {
      line += fmt::format(" found by {}", walk);
    } else if (const auto distance_m = pipeline::moved_m(thing, event, keyframes_)) {
      const std::string from = room_before(event);
      line += fmt::format(" moved by {:.1f} m{} on {}", *distance_m,
                          from.empty() ? "" : ", from the " + from + ",", walk);
    } else {
      line += fmt::format(" {} on {}", pipeline::to_string(event.what), walk);
    }
  }
  const auto when = walks_.date(thing.last_seen.time_ns);
  return line + fmt::format("; last seen on {}{}", walks_.name(thing.last_seen.walk),
                            when ? ", " + *when : std::string());
}

std::vector<std::string> HistoryWords::changes(home::RecordingId walk) const {
  std::vector<std::string> lines;
  for (const auto& [thing, event] : history_.changes_by(walk)) {
    const std::string in = room(*thing);
    std::string line = fmt::format("{} {}", thing->thing.name, pipeline::to_string(event->what));
    if (const auto distance_m = pipeline::moved_m(*thing, *event, keyframes_)) {
      const std::string from = room_before(*event);
      line += fmt::format(" by {:.1f} m", *distance_m);
      if (!from.empty() && from != in) line += ", from the " + from;
    }
    lines.push_back(line + (in.empty() ? "" : fmt::format(" ({})", in)));
  }
  return lines;
}

Json HistoryWords::event_json(const ThingHistory& thing, const WalkEvent& event) const {
  const auto distance_m = pipeline::moved_m(thing, event, keyframes_);
  return {{"what", pipeline::to_string(event.what)},
          {"moved_m", distance_m ? Json(*distance_m) : Json(nullptr)},
          {"room_before", word_or_null(room_before(event))}};
}

Json HistoryWords::changes_json(home::RecordingId walk) const {
  Json changes = Json::array();
  for (const auto& [thing, event] : history_.changes_by(walk)) {
    Json one = event_json(*thing, *event);
    one["name"] = thing->thing.name;
    one["room"] = word_or_null(room(*thing));
    changes.push_back(std::move(one));
  }
  return changes;
}

Json HistoryWords::events_json(const ThingHistory& thing) const {
  Json events = Json::array();
  for (const WalkEvent& event : thing.events) {
    Json one = event_json(thing, event);
    one["walk"] = walks_.name(event.walk);
    events.push_back(std::move(one));
  }
  return events;
}

Json HistoryWords::sighting_json(const pipeline::Sighting& seen) const {
  return {{"walk", walks_.name(seen.walk)},
          {"time_s", seconds_between(0, seen.time_ns)},
          {"date", date_json(seen.time_ns)}};
}

}  // namespace roomwise::app
