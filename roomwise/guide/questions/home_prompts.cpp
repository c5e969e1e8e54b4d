#include "roomwise/guide/questions/home_prompts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "roomwise/guide/answers/seen_prompt.h"
#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/way/legs.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

constexpr std::size_t kThingsOfAPrompt = 4;  // more is forgotten before the last is spoken
constexpr double kFarthestAhead_m = 6;
constexpr double kHalfPerson_m = 0.25;

// An answer in the making.
class HomeAnswer {
 public:
  HomeAnswer(std::string key, const Wording& wording, const Today& today)
      : key_(std::move(key)), wording_(wording), today_(today) {}

  void say(const std::string& message, const Values& values, double valid_s = kHomeValid_s,
           bool is_sure = true) {
    prompts_.push_back(make_part(wording_, key_, prompts_.size(), message, values,
                                 is_sure ? Confidence::kSure : Confidence::kProbable, today_.now_ns,
                                 valid_s, "by the map of the home"));
  }
  void say_unsure(const std::string& message, const Values& values = {}) {
    prompts_.push_back(make_prompt(wording_, key_, message, values, Confidence::kUnsure,
                                   after(today_.now_ns, kRoomValid_s), "the map does not tell"));
  }
  // Several prompts where there are many.
  void list(const std::string& message, Values values, const std::string& value, const Nouns& nouns,
            bool is_sure = true) {
    for (std::size_t i = 0; i < nouns.size(); i += kThingsOfAPrompt) {
      const auto begin = nouns.begin() + static_cast<std::ptrdiff_t>(i);
      const std::size_t count = std::min(kThingsOfAPrompt, nouns.size() - i);
      const Nouns some(begin, begin + static_cast<std::ptrdiff_t>(count));
      values[i == 0 ? value : "things"] = some;
      say(i == 0 ? message : "describe.then", values, kHomeValid_s, is_sure);
    }
  }
  // Those that are sure first, then the others as probable, each name once.
  void say_things(const std::string& message, const Values& values,
                  std::span<const KnownThing* const> things) {
    for (const bool is_sure : {true, false}) {
      const Nouns nouns = names_of(things, is_sure, today_.date);
      list(message + (is_sure ? "" : "_probable"), values, "things", nouns, is_sure);
    }
    say_seen(things);
  }
  // When the one was seen that was not seen for longest.
  void say_seen(std::span<const KnownThing* const> things) {
    std::optional<CalendarTime> oldest;
    for (const KnownThing* thing : things) {
      const bool is_older = thing->seen && (!oldest || thing->seen->days_until(*oldest) > 0);
      if (is_older) oldest = thing->seen;
    }
    auto seen = seen_prompt(part_key(key_, prompts_.size()), oldest, today_.date, wording_,
                            today_.now_ns, "one was not seen since then");
    if (seen) prompts_.push_back(*std::move(seen));
  }
  [[nodiscard]] bool empty() const { return prompts_.empty(); }
  [[nodiscard]] std::vector<Prompt> take() { return std::move(prompts_); }

 private:
  static Nouns names_of(std::span<const KnownThing* const> things, bool is_sure,
                        const std::optional<CalendarTime>& today) {
    Nouns nouns;
    for (const KnownThing* thing : things) {
      const bool is_known = std::ranges::count(nouns, thing->name, &Noun::name) > 0;
      if (thing->is_sure(today) == is_sure && !is_known) {
        nouns.push_back({Noun::Kind::kThing, thing->name});
      }
    }
    return nouns;
  }

  std::string key_;
  const Wording& wording_;
  const Today& today_;
  std::vector<Prompt> prompts_;
};

// Of a thing that has a place; 0 where the person's is not known.
double distance_to(const KnownThing& thing, const UserLocation& location) {
  const Pose* const pose = location.sure_pose();
  if (pose == nullptr) return 0;
  return outline_of(thing).distance_m(pose->position_plan);
}

std::vector<const KnownThing*> things_in(const std::string& room, const HomeMap& map) {
  std::vector<const KnownThing*> there;
  for (const KnownThing& thing : map.things) {
    if (thing.room == room) there.push_back(&thing);
  }
  std::ranges::stable_sort(there, std::ranges::greater{}, &KnownThing::probability);
  return there;
}

const rooms::RoomExtent* extent_of(const std::string& room, const HomeMap& map) {
  if (map.layout == nullptr) return nullptr;
  const auto found = std::ranges::find(map.layout->rooms(), room, &rooms::RoomExtent::name);
  return found == map.layout->rooms().end() ? nullptr : &*found;
}

// Of the room; the nearest first where the person's place is known, else the widest.
std::vector<const rooms::Doorway*> doors_of_room(const std::string& room, const HomeMap& map,
                                                 const UserLocation& location) {
  std::vector<const rooms::Doorway*> doors;
  for (const rooms::Doorway& door : map.doorways) {
    if (door.joins(room)) doors.push_back(&door);
  }
  const Pose* const pose = location.sure_pose();
  std::ranges::stable_sort(doors, {}, [&](const rooms::Doorway* door) {
    return pose != nullptr ? (door->place_in(room) - pose->position_plan).norm() : -door->width_m;
  });
  return doors;
}

double clockwise_rad(double from_rad, double to_rad) {
  const double turn_rad = std::fmod(from_rad - to_rad, 2 * std::numbers::pi);
  return turn_rad < 0 ? turn_rad + 2 * std::numbers::pi : turn_rad;
}

double angle_rad(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return std::atan2(to.y() - from.y(), to.x() - from.x());
}

struct Ahead {
  double distance_m = 0;
  fusion::FloorCell cell = fusion::FloorCell::kFree;  // what ends the free floor there
  Eigen::Vector2d place_plan = Eigen::Vector2d::Zero();
};

// Along one line beside the heading. What somebody stands beside, up against it, is not ahead.
Ahead look_along(const fusion::FloorGrid& floor, const Pose& pose, double aside_m) {
  const Eigen::Vector2d forward(std::cos(pose.heading_rad), std::sin(pose.heading_rad));
  const Eigen::Vector2d left(-forward.y(), forward.x());
  Ahead ahead;
  bool is_beside = aside_m != 0;
  for (ahead.distance_m = 0; ahead.distance_m < kFarthestAhead_m;
       ahead.distance_m += floor.cell_m() / 2) {
    ahead.place_plan = pose.position_plan + ahead.distance_m * forward + aside_m * left;
    ahead.cell = floor.at(ahead.place_plan);
    is_beside = is_beside && ahead.cell == fusion::FloorCell::kOccupied;
    if (ahead.cell != fusion::FloorCell::kFree && !is_beside) return ahead;
  }
  ahead.cell = fusion::FloorCell::kFree;
  return ahead;
}

Ahead look_ahead(const fusion::FloorGrid& floor, const Pose& pose) {
  Ahead nearest = look_along(floor, pose, 0);
  for (const double aside_m : {-kHalfPerson_m, kHalfPerson_m}) {
    const Ahead one = look_along(floor, pose, aside_m);
    if (one.distance_m < nearest.distance_m) nearest = one;
  }
  return nearest;
}

void say_ahead_by_map(const HomeMap& map, const Pose& pose, bool is_looked_at,
                      const Wording& wording, const Today& today, HomeAnswer& answer) {
  const Ahead ahead = look_ahead(*map.floor, pose);
  Values values{{"distance", wording.distance(ahead.distance_m)}};
  const auto say = [&](const std::string& message, bool is_sure) {
    answer.say(message + (is_looked_at ? "" : "_by_map"), values, kDirectionValid_s,
               is_sure && is_looked_at);
  };
  const bool is_occupied = ahead.cell == fusion::FloorCell::kOccupied;
  // Who was told that something is ahead does not want to hear that the map has nothing there.
  if (!answer.empty() && !is_occupied) return;
  if (ahead.cell == fusion::FloorCell::kUnknown && ahead.distance_m == 0) {
    return answer.say_unsure("ahead.unknown");
  }
  if (!is_occupied) return say("ahead.free", true);
  const KnownThing* const there = thing_at(ahead.place_plan, map);
  if (there == nullptr) return say("ahead.something", true);
  values["thing"] = thing(there->name);
  const bool is_sure = there->is_sure(today.date);
  say(is_sure || !is_looked_at ? "ahead.thing" : "ahead.thing_probable", is_sure);
}

}  // namespace

std::vector<Prompt> on_prompts(const std::string& surface, const HomeMap& map,
                               const UserLocation& location, const Wording& wording,
                               const Today& today) {
  HomeAnswer answer("on " + surface, wording, today);
  std::vector<const KnownThing*> surfaces;
  for (const KnownThing& thing : map.things) {
    if (thing.name == surface && thing.position_plan) surfaces.push_back(&thing);
  }
  std::ranges::stable_sort(surfaces, {}, [&](const KnownThing* one) {
    return std::pair(distance_to(*one, location), -one->probability);
  });
  const Values values{{"thing", thing(surface)}};
  if (surfaces.empty()) {
    answer.say_unsure("on.no_place", values);
    return answer.take();
  }
  std::vector<const KnownThing*> there;
  for (const KnownThing& thing : map.things) {
    if (stands_on(thing, *surfaces.front())) there.push_back(&thing);
  }
  if (there.empty()) answer.say("on.nothing", values);
  answer.say_things("on.things", values, there);
  return answer.take();
}

std::vector<Prompt> in_prompts(const std::string& room, const HomeMap& map, const Wording& wording,
                               const Today& today) {
  HomeAnswer answer("in " + room, wording, today);
  const Values values{{"room", guide::room(room)}};
  const auto there = things_in(room, map);
  if (there.empty()) answer.say("in.nothing", values);
  answer.say_things("in.things", values, there);
  return answer.take();
}

std::vector<Prompt> rooms_prompts(const std::vector<std::string>& rooms, const Wording& wording,
                                  const Today& today) {
  HomeAnswer answer("rooms", wording, today);
  const auto count = wording.phrases().count("room", static_cast<double>(rooms.size()));
  answer.say("rooms.count", {{"count", count}});
  answer.list("rooms.list", {}, "rooms", room_list(rooms));
  return answer.take();
}

std::vector<Prompt> room_way_prompts(const std::string& room, const HomeMap& map,
                                     const UserLocation& location, const Wording& wording,
                                     const Today& today) {
  HomeAnswer answer("room " + room, wording, today);
  const Nouns goal = guide::room(room);
  if (location.room == room) {
    answer.say("room.is", {{"room", goal}}, kRoomValid_s);
    return answer.take();
  }
  const auto way = location.room ? way_between_rooms(*location.room, room, map.doorways)
                                 : std::vector<std::string>{};
  const rooms::RoomExtent* const extent = extent_of(room, map);
  const Pose* const pose = location.sure_pose();
  if (way.size() == 2) {
    answer.say("guide.room_next", {{"goal", goal}}, kRoomValid_s);
  } else if (way.size() > 2) {
    const Nouns via = room_list({way.begin() + 1, way.end() - 1});
    answer.say("guide.room_through", {{"goal", goal}, {"via", via}}, kRoomValid_s);
  }
  const bool has_direction = pose != nullptr && extent != nullptr && extent->floor_m2 > 0 &&
                             map.are_on_one_storey(pose->position_plan, extent->middle_plan);
  if (has_direction) {
    const Bearing bearing = bearing_of(extent->middle_plan, *pose);
    answer.say(bearing.is_sure ? "where.direction" : "where.direction_probable",
               {{"thing", goal},
                {"hour", fmt::format("{}", bearing.hour)},
                {"distance", wording.distance(bearing.distance_m)}},
               kDirectionValid_s, bearing.is_sure);
  }
  if (answer.empty()) answer.say_unsure(pose != nullptr ? "route.none" : "route.no_place");
  return answer.take();
}

std::vector<Prompt> facing_prompts(const HomeMap& map, const UserLocation& location,
                                   const Wording& wording, const Today& today) {
  HomeAnswer answer("facing", wording, today);
  const Pose* const pose = location.sure_pose();
  if (pose == nullptr) {
    answer.say_unsure("route.no_place");
    return answer.take();
  }
  struct Faced {
    Bearing bearing;
    Noun noun;
    bool is_sure = true;
  };
  std::optional<Faced> nearest;
  const auto consider = [&](const Bearing& bearing, const Noun& noun, bool is_sure) {
    const bool is_nearer = !nearest || bearing.distance_m < nearest->bearing.distance_m;
    if (bearing.hour == 12 && is_nearer) nearest = {bearing, noun, is_sure && bearing.is_sure};
  };
  for (const KnownThing& thing : map.things) {
    const bool is_elsewhere = location.room && thing.room && *thing.room != *location.room;
    const auto bearing = bearing_of(thing, *pose);
    const bool is_here = bearing && !is_elsewhere &&
                         map.are_on_one_storey(pose->position_plan, thing.position_plan->head<2>());
    if (is_here) {
      consider(*bearing, {Noun::Kind::kThing, thing.name}, thing.is_sure(today.date));
    }
  }
  for (const rooms::Doorway& door : doors_of(map.doorways)) {
    if (!location.room || !door.joins(*location.room)) continue;
    consider(bearing_of(door.middle_plan, *pose), Goal::of(door).noun, true);
  }
  if (nearest) {
    answer.say(nearest->is_sure ? "facing.place" : "facing.place_probable",
               {{"place", Nouns{nearest->noun}},
                {"distance", wording.distance(nearest->bearing.distance_m)}},
               kDirectionValid_s, nearest->is_sure);
  } else {
    answer.say_unsure("facing.nothing");
  }
  return answer.take();
}

std::vector<Prompt> ahead_prompts(const HomeMap& map, const UserLocation& location,
                                  const DepthAhead& depth, const Wording& wording,
                                  const Today& today) {
  HomeAnswer answer("ahead", wording, today);
  if (depth.obstacle_m) {
    answer.say("ahead.now", {{"distance", wording.distance(*depth.obstacle_m)}}, kDirectionValid_s);
  }
  const Pose* const pose = location.sure_pose();
  if (pose != nullptr && map.floor != nullptr) {
    say_ahead_by_map(map, *pose, depth.is_measured, wording, today, answer);
  }
  if (answer.empty()) answer.say_unsure("ahead.unknown");
  return answer.take();
}

std::vector<Prompt> describe_prompts(const std::string& room, const HomeMap& map,
                                     const UserLocation& location, const Wording& wording,
                                     const Today& today) {
  HomeAnswer answer("describe " + room, wording, today);
  const rooms::RoomExtent* const extent = extent_of(room, map);
  const Values values{{"room", guide::room(room)}};
  const bool is_large_enough = extent != nullptr && extent->floor_m2 >= 1;
  if (is_large_enough) {
    const auto area = wording.phrases().count("square_metre", std::round(extent->floor_m2));
    answer.say("describe.floor", {{"room", guide::room(room)}, {"area", area}});
  } else {
    answer.say("describe.unknown", values);
  }
  const auto doors = doors_of_room(room, map, location);
  std::vector<std::string> others;
  for (const rooms::Doorway* door : doors) {
    const std::string& other = door->rooms[0] == room ? door->rooms[1] : door->rooms[0];
    if (std::ranges::count(others, other) == 0) others.push_back(other);
  }
  answer.list("describe.leads_to", {}, "rooms", room_list(others));
  for (const rooms::Doorway* door : doors) {
    const DoorWidth width = width_of(*door);
    if (!door->is_door() || width == DoorWidth::kUsual) continue;
    answer.say(width == DoorWidth::kNarrow ? "describe.narrow" : "describe.wide",
               {{"room", guide::room(door->rooms[door->rooms[0] == room ? 1 : 0])},
                {"width", width_text(door->width_m, wording.phrases())}});
  }
  auto there = things_in(room, map);
  if (there.empty() || doors.empty() || extent == nullptr) {
    if (there.empty()) answer.say("in.nothing", values);
    answer.say_things("in.things", values, there);
    return answer.take();
  }
  const Eigen::Vector2d& middle = extent->middle_plan;
  // A door is found by hand; of rooms that are open to each other the way there is told.
  const auto door = std::ranges::find_if(doors, &rooms::Doorway::is_door);
  const rooms::Doorway& first = door != doors.end() ? **door : *doors.front();
  const double door_rad = angle_rad(middle, first.place_in(room));
  std::erase_if(there, [](const KnownThing* one) { return !one->position_plan; });
  std::ranges::stable_sort(there, {}, [&](const KnownThing* one) {
    return clockwise_rad(door_rad, angle_rad(middle, one->position_plan->head<2>()));
  });
  const std::string& beyond = first.rooms[0] == room ? first.rooms[1] : first.rooms[0];
  if (first.is_door()) {
    answer.say_things("describe.clockwise", {}, there);
  } else {
    answer.say_things("describe.clockwise_way", {{"room", guide::room(beyond)}}, there);
  }
  return answer.take();
}

std::vector<Prompt> change_prompts(const ChangedThings& changed, const Wording& wording,
                                   const Today& today) {
  HomeAnswer answer("changed", wording, today);
  std::vector<const KnownThing*> all;
  const auto say = [&](const std::string& message, std::span<const KnownThing> things) {
    std::map<std::string, Nouns> of_room;
    Nouns somewhere;
    for (const KnownThing& thing : things) {
      (thing.room ? of_room[*thing.room] : somewhere).push_back({Noun::Kind::kThing, thing.name});
      all.push_back(&thing);
    }
    for (const auto& [room, names] : of_room) {
      answer.list(message, {{"room", guide::room(room)}}, "things", names);
    }
    answer.list(message + "_somewhere", {}, "things", somewhere);
  };
  say("changed.new", changed.arrived);
  say("changed.moved", changed.moved);
  say("changed.shifted", changed.shifted);
  say("changed.gone", changed.gone);
  if (changed.empty()) answer.say("changed.none", {});
  answer.say_seen(all);
  return answer.take();
}

}  // namespace roomwise::guide
