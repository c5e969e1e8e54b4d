#include <algorithm>
#include <array>
#include <limits>
#include <tuple>

#include "roomwise/guide/answers/seen_prompt.h"
#include "roomwise/guide/answers/thing_prompts.h"
#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/way/plan.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

constexpr std::size_t kMaxRoomsToName = 2;  // on the way

struct Candidate {
  const KnownThing* thing = nullptr;
  // From the room of the person to that of the thing; empty where one is not known, or no way.
  std::vector<std::string> way;
  std::optional<Bearing> bearing;
  bool knows_rooms = false;  // of both

  // In the same room, as far as that is known; else so near that it will be.
  [[nodiscard]] bool is_here() const {
    return knows_rooms ? way.size() == 1 : bearing && bearing->distance_m <= kSameRoom_m;
  }
  // Fewer doors first, then the shorter way, then the surer.
  [[nodiscard]] auto rank() const {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const std::size_t doors = way.empty() ? std::numeric_limits<std::size_t>::max() : way.size();
    return std::tuple(doors, bearing ? bearing->distance_m : kFar, -thing->probability);
  }
};

// Of the name; without one of all.
std::vector<Candidate> nearest_first(const std::optional<std::string>& name,
                                     const UserLocation& location,
                                     std::span<const KnownThing> things,
                                     std::span<const rooms::Doorway> doorways) {
  std::vector<Candidate> candidates;
  const Pose* pose = location.sure_pose();
  for (const KnownThing& thing : things) {
    if (name && thing.name != *name) continue;
    Candidate candidate{&thing, {}, std::nullopt, location.room && thing.room};
    if (candidate.knows_rooms) {
      candidate.way = way_between_rooms(*location.room, *thing.room, doorways);
    }
    if (pose != nullptr) candidate.bearing = bearing_of(thing, *pose);
    candidates.push_back(std::move(candidate));
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::rank);
  return candidates;
}

// What to say of a thing, and how long that holds.
struct Place {
  std::string message_id;
  Values values;
  double valid_s = kHomeValid_s;
  bool is_sure = true;
};

Place place_of(const Candidate& candidate, const Wording& wording,
               const std::optional<CalendarTime>& today) {
  const KnownThing& thing = *candidate.thing;
  Place place{.message_id = {}, .values = {{"thing", guide::thing(thing.name)}}};
  place.is_sure = thing.is_sure(today);
  if (candidate.is_here() && candidate.bearing) {
    const Bearing& bearing = *candidate.bearing;
    place.message_id = bearing.is_close() ? "where.close" : "where.direction";
    place.values["hour"] = fmt::format("{}", bearing.hour);
    place.values["distance"] = wording.distance(bearing.distance_m);
    place.valid_s = kDirectionValid_s;
    place.is_sure = place.is_sure && bearing.is_sure && candidate.knows_rooms;
    return place;
  }
  if (!thing.room) {
    place.message_id = "where.no_room";
    return place;
  }
  place.values["room"] = room(*thing.room);
  const std::size_t rooms = candidate.way.size();
  if (rooms == 1) place.message_id = "where.here";
  if (rooms == 2) place.message_id = "where.next_room";
  if (rooms > 2 && rooms - 2 <= kMaxRoomsToName) {
    place.message_id = "where.through";
    place.values["via"] = room_list({candidate.way.begin() + 1, candidate.way.end() - 1});
  }
  if (place.message_id.empty()) {
    place.message_id = "where.room";
  } else {
    place.valid_s = kRoomValid_s;  // seen from this room
  }
  return place;
}

std::string key_of(const std::string& name) {
  return "thing " + name;
}

bool is_carried_about(const std::string& name) {
  const objects::Kind* kind = objects::find_kind(name);
  return kind != nullptr && kind->is_moved_about;
}

// Of what people carry about, the answer's second part.
std::optional<Prompt> seen_part(const KnownThing& thing, const Wording& wording, TimestampNs now_ns,
                                const std::optional<CalendarTime>& today) {
  if (thing.added_by_edit != 0 || (!thing.is_taught && !is_carried_about(thing.name)))
    return std::nullopt;
  return seen_prompt(key_of(thing.name) + "/seen", thing.seen, today, wording, now_ns,
                     "people carry such things about");
}

// What a helper said of it: that it is there, and what they noted.
std::vector<Prompt> helper_parts(const KnownThing& thing, const Wording& wording,
                                 TimestampNs now_ns) {
  std::vector<Prompt> parts;
  const auto add = [&](const char* part, const std::string& message, const Values& values,
                       const char* because) {
    parts.push_back(make_prompt(wording, key_of(thing.name) + part, message, values,
                                Confidence::kSure, after(now_ns, kHomeValid_s), because));
    parts.back().sound = Sound::kNone;
  };
  if (thing.added_by_edit != 0) add("/added", "where.added", {}, "no picture shows it");
  if (!thing.note.empty())
    add("/note", "where.note", {{"note", as_sentence(thing.note)}}, "a helper's note");
  return parts;
}

// Of what somebody taught, what it lies on.
std::optional<Prompt> surface_part(const KnownThing& thing, std::span<const KnownThing> things,
                                   const Wording& wording, TimestampNs now_ns) {
  const KnownThing* const surface = thing.is_taught ? surface_under(thing, things) : nullptr;
  if (surface == nullptr) return std::nullopt;
  Prompt prompt = make_prompt(wording, key_of(thing.name) + "/on", "where.on",
                              {{"thing", guide::thing(surface->name)}}, Confidence::kSure,
                              after(now_ns, kHomeValid_s), "there it was seen last");
  prompt.sound = Sound::kNone;
  return prompt;
}

Prompt unknown_thing(const std::string& asked, const Wording& wording, TimestampNs now_ns) {
  const auto words = wording.phrases().words_for(Noun::Kind::kThing, asked);
  const std::string name = words.empty() ? asked : words.front();
  if (std::ranges::count(words, kNameOfWayOut) > 0) {
    return make_prompt(wording, key_of(kNameOfWayOut), "where.no_way_out", {}, Confidence::kSure,
                       after(now_ns, kHomeValid_s), "nobody added it");
  }
  return make_prompt(wording, key_of(name), "where.unknown", {{"thing", thing(name)}},
                     Confidence::kSure, after(now_ns, kHomeValid_s),
                     "the map has no thing of this name");
}

}  // namespace

std::optional<std::string> thing_meant(const std::string& asked, std::span<const KnownThing> things,
                                       const objects::ObjectVocabulary& vocabulary,
                                       const Phrasebook& phrases) {
  const auto has = [&](const std::string& name) {
    return std::ranges::find(things, name, &KnownThing::name) != things.end();
  };
  if (has(asked)) return asked;
  for (const KnownThing& thing : things) {
    if (objects::same_label(thing.name, asked)) return thing.name;
  }
  for (const std::string& word : phrases.words_for(Noun::Kind::kThing, asked)) {
    if (has(word)) return word;
  }
  const auto object = vocabulary.object_of(asked);
  return object && has(*object) ? object : std::nullopt;
}

std::vector<Prompt> where_prompts(const std::string& asked, const UserLocation& location,
                                  std::span<const KnownThing> things,
                                  std::span<const rooms::Doorway> doorways,
                                  const objects::ObjectVocabulary& vocabulary,
                                  const Wording& wording, TimestampNs now_ns,
                                  const std::optional<CalendarTime>& today) {
  const auto name = thing_meant(asked, things, vocabulary, wording.phrases());
  if (!name) return {unknown_thing(asked, wording, now_ns)};
  const auto own = std::ranges::find(things, *name, &KnownThing::name);
  if (own->is_taught && !own->room && !own->position_plan && !own->seen) {
    return {make_prompt(wording, key_of(*name), "where.not_seen", {{"thing", thing(*name)}},
                        Confidence::kUnsure, after(now_ns, kHomeValid_s),
                        "it was taught, and no picture has shown it since")};
  }
  const auto candidates = nearest_first(*name, location, things, doorways);
  const Candidate& nearest = candidates.front();
  Place place = place_of(nearest, wording, today);
  const bool has_variant = place.message_id != "where.no_room";
  const Confidence confidence = !has_variant    ? Confidence::kUnsure
                                : place.is_sure ? Confidence::kSure
                                                : Confidence::kProbable;
  if (confidence == Confidence::kProbable) place.message_id += "_probable";
  const std::string because =
      fmt::format("the map has {} of this name; the probability that this one is there is {:.2f}",
                  candidates.size(), nearest.thing->probability_at(today));
  std::vector<Prompt> prompts{make_prompt(wording, key_of(*name), place.message_id, place.values,
                                          confidence, after(now_ns, place.valid_s), because)};
  if (auto surface = surface_part(*nearest.thing, things, wording, now_ns)) {
    prompts.push_back(*std::move(surface));
  }
  if (auto seen = seen_part(*nearest.thing, wording, now_ns, today)) {
    prompts.push_back(*std::move(seen));
  }
  std::ranges::move(helper_parts(*nearest.thing, wording, now_ns), std::back_inserter(prompts));
  if (candidates.size() > 1) {
    const bool knows_nearest = !nearest.way.empty() || nearest.bearing;
    Prompt count = make_prompt(
        wording, key_of(*name) + "/count", knows_nearest ? "where.count" : "where.count_anywhere",
        {{"count", fmt::format("{}", candidates.size())}, {"thing", thing(*name)}},
        Confidence::kSure, after(now_ns, kHomeValid_s), because);
    count.sound = Sound::kNone;
    prompts.push_back(std::move(count));
  }
  return prompts;
}

std::vector<Prompt> seat_prompts(const UserLocation& location, std::span<const KnownThing> things,
                                 std::span<const rooms::Doorway> doorways,
                                 const objects::ObjectVocabulary& vocabulary,
                                 const Wording& wording, TimestampNs now_ns,
                                 const std::optional<CalendarTime>& today) {
  std::vector<KnownThing> seats;
  for (const KnownThing& thing : things) {
    const objects::Kind* const kind = objects::find_kind(thing.name);
    if (kind != nullptr && kind->is_seat) seats.push_back(thing);
  }
  const auto nearest = nearest_first(std::nullopt, location, seats, doorways);
  if (nearest.empty()) {
    return {make_prompt(wording, "seat", "sit.nowhere", {}, Confidence::kUnsure,
                        after(now_ns, kHomeValid_s), "the map has no thing of such a kind")};
  }
  if (nearest.front().is_here()) return around_prompts(location, seats, wording, now_ns, today);
  return where_prompts(nearest.front().thing->name, location, seats, doorways, vocabulary, wording,
                       now_ns, today);
}

Prompt no_door_prompt(const std::string& room, const std::string& other_room,
                      const Wording& wording, TimestampNs now_ns) {
  Values values{{"room", guide::room(room)}};
  if (!other_room.empty()) values.emplace("other", guide::room(other_room));
  return make_prompt(wording, key_of("door"),
                     other_room.empty() ? "where.no_door" : "where.no_door_between", values,
                     Confidence::kSure, after(now_ns, kHomeValid_s),
                     "the map has no door there that a hand finds");
}

}  // namespace roomwise::guide
