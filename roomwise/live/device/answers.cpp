#include "roomwise/live/device/answers.h"

#include <cmath>
#include <map>
#include <set>

#include "roomwise/guide/answers/room_prompts.h"
#include "roomwise/guide/answers/route_prompts.h"
#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/guide/answers/thing_prompts.h"
#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/questions/home_prompts.h"
#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/guide/way/legs.h"

namespace roomwise::live {
namespace {

const guide::MessageCatalogue& catalogue() {
  static const guide::MessageCatalogue built_in = guide::MessageCatalogue::built_in();
  return built_in;
}

// The language that is spoken to somebody who wants `tag` ("de-AT"): English where theirs is not
// known.
std::string spoken_language(const std::string& tag) {
  const std::string language = tag.substr(0, tag.find('-'));
  return catalogue().speaks(language) ? language : "en";
}

// More are no choice to remember: then it is the nearest.
constexpr std::size_t kMostChoices = 4;

TimestampNs nanoseconds(double t_ms) {
  return std::llround(t_ms * 1e6);
}

// That a name is one of the way out: "way out", "exit", "front door".
bool means_way_out(const std::string& name, const guide::Phrasebook& phrases) {
  return std::ranges::count(phrases.words_for(guide::Noun::Kind::kThing, name),
                            guide::kNameOfWayOut) > 0;
}

guide::TurnHint hint_of(const FrameResult& result) {
  if (!result.more_to_see) return guide::TurnHint::kAnywhere;
  return *result.more_to_see == pipeline::Side::kLeft ? guide::TurnHint::kLeft
                                                      : guide::TurnHint::kRight;
}

// Of the computer's or the device's state: what there is to say instead of an answer.
guide::Prompt unavailable(const std::string& message, const guide::Wording& wording,
                          double now_t_ms) {
  return guide::make_prompt(wording, "answer", message, {}, guide::Confidence::kUnsure,
                            guide::after(nanoseconds(now_t_ms), guide::kNoticeValid_s));
}

// The room by a picture. Pictures speak for no room that was not learned, and may not tell one that
// was: then the place on the map answers.
std::optional<rooms::RoomDecision> decision_of(const FrameResult& result, const HomeView& home) {
  const auto& by_pictures = result.decision;
  const bool is_named = by_pictures && by_pictures->verdict == rooms::Verdict::kRoom;
  if (is_named || !result.place) return by_pictures;
  auto by_place = home.room_around(result.place->position_plan(), result.place->sigma_m);
  if (!by_place) return by_pictures;
  if (by_pictures) {
    const auto learned =
        std::ranges::find(by_pictures->rooms, by_place->room, &rooms::RoomScore::room);
    if (learned != by_pictures->rooms.end()) {
      if (by_pictures->allows(by_place->room)) return by_pictures;
      // Two opinions that differ count alike (the linear opinion pool: Stone 1961).
      by_place->score = (by_place->score + learned->score) / 2;
    }
  }
  if (by_place->score < 0.5) return by_pictures;
  rooms::RoomDecision decision;
  decision.verdict = rooms::Verdict::kRoom;
  decision.why = fmt::format("the place on the map lies in {}", by_place->room);
  decision.rooms = {*std::move(by_place)};
  return decision;
}

guide::Prompt where_am_i(const Situation& situation, const guide::Wording& wording) {
  const HomeView& home = situation.home;
  const FrameResult* const result = situation.result;
  if (result != nullptr) {
    if (const auto decision = decision_of(*result, home)) {
      return guide::room_prompt(*decision, hint_of(*result), wording, nanoseconds(result->t_ms));
    }
  }
  const bool knows_rooms = home.recognizer != nullptr || (home.map && !home.rooms.empty());
  if (!knows_rooms) return unavailable("device.nothing_learned", wording, situation.now_t_ms);
  if (result == nullptr) {
    return no_picture(situation.had_pictures, wording, situation.now_t_ms);
  }
  return unavailable("route.no_place", wording, situation.now_t_ms);
}

// The thing of the map that depth shows in the way, where that is certain.
const guide::KnownThing* sure_thing_ahead(const Situation& situation) {
  const FrameResult& result = *situation.result;
  if (!result.place) return nullptr;
  guide::HomeMap map = map_of(situation.home, {});
  map.today = situation.today;
  return guide::sure_thing_of(*result.obstacle, result.place->on_floor(), map);
}

// That the home has no such door, where one is asked for by its rooms.
std::optional<guide::Prompt> no_door(const service::Ask& ask, const HomeView& home,
                                     const guide::Wording& wording, TimestampNs now_ns) {
  const auto doors = doors_asked_for(ask, home, wording.phrases());
  if (!doors || !doors->empty() || ask.in_room.empty()) return std::nullopt;
  return guide::no_door_prompt(ask.in_room, ask.to_room, wording, now_ns);
}

// The room of the home that somebody means: by its own name, or as it is called in their language.
std::optional<std::string> room_meant(const std::string& asked, const HomeView& home,
                                      const guide::Phrasebook& phrases) {
  const auto has = [&](const std::string& name) {
    return std::ranges::find(home.rooms, name, &rooms::Room::name) != home.rooms.end();
  };
  if (has(asked)) return asked;
  const auto words = phrases.words_for(guide::Noun::Kind::kRoom, asked);
  const auto found = std::ranges::find_if(words, has);
  return found == words.end() ? std::nullopt : std::optional(*found);
}

// That the room in which a thing is asked for has none, where another one has.
std::optional<guide::Prompt> none_in_room(const service::Ask& ask, const HomeView& home,
                                          const guide::Wording& wording, TimestampNs now_ns) {
  if (ask.is_way_out || !room_meant(ask.in_room, home, wording.phrases())) return std::nullopt;
  if (doors_asked_for(ask, home, wording.phrases())) return std::nullopt;
  const auto meant = [&](std::span<const guide::KnownThing> things) {
    return guide::thing_meant(ask.subject, things, home.concepts.vocabulary, wording.phrases());
  };
  const auto anywhere = meant(home.things);
  if (!anywhere || meant(things_asked_for(ask, home, wording.phrases()))) return std::nullopt;
  return guide::none_in_room_prompt(guide::thing(*anywhere).front(), ask.in_room, wording, now_ns);
}

// The way from where somebody stands to the nearest thing that they mean.
std::vector<guide::Prompt> way_to(const service::Ask& ask, const Situation& situation,
                                  const guide::Wording& wording, TimestampNs now_ns) {
  const HomeView& home = situation.home;
  if (auto none = no_door(ask, home, wording, now_ns)) return {*std::move(none)};
  if (auto none = none_in_room(ask, home, wording, now_ns)) return {*std::move(none)};
  const std::string asked = name_asked_for(ask);
  const auto things = things_asked_for(ask, home, wording.phrases());
  const guide::UserLocation location = standing_of(situation.result);
  const auto meant = guide::thing_meant(asked, things, home.concepts.vocabulary, wording.phrases());
  if (!meant) {  // says so
    return guide::where_prompts(asked, location, things, {}, home.concepts.vocabulary, wording,
                                now_ns, situation.today);
  }
  const guide::Pose* const pose = location.sure_pose();
  if (pose == nullptr)
    return {guide::no_route_prompt(false, "no place on the map", wording, now_ns)};
  const auto stairs =
      home.map ? std::span(home.map->frame.storeys.stairs()) : std::span<const fusion::Staircase>();
  const fusion::FloorGrid* const found = situation.found_floor;
  std::optional<guide::Route> shortest;
  bool is_sure = true;  // that the thing is there
  std::string why = "its place is not known";
  for (const guide::KnownThing& thing : things) {
    if (thing.name != *meant || !thing.position_plan || !home.map || !home.map->floor) continue;
    const fusion::FloorGrid& floor = found != nullptr ? *found : *home.map->floor;
    auto route = guide::find_route(floor, pose->position_plan, thing.position_plan->head<2>(), {},
                                   home.layout ? &*home.layout : nullptr, thing.room, stairs);
    if (!route) {
      why = route.error().message;
    } else if (!shortest || guide::length_m(*route, stairs) < guide::length_m(*shortest, stairs)) {
      shortest = *std::move(route);
      is_sure = thing.is_sure(situation.today);
    }
  }
  if (!shortest) return {guide::no_route_prompt(true, why, wording, now_ns)};
  return guide::route_prompts(*shortest, *pose, guide::thing(*meant).front(), doorways_of(home),
                              wording, now_ns, stairs,
                              is_sure ? guide::Confidence::kSure : guide::Confidence::kProbable);
}

std::vector<guide::KnownThing> as_things(std::span<const rooms::Doorway> doors,
                                         const guide::UserLocation& location) {
  std::vector<guide::KnownThing> things;
  for (const rooms::Doorway& door : doors) {
    const guide::Goal goal = guide::Goal::of(door);
    guide::KnownThing& thing = things.emplace_back();
    thing.name = goal.noun.name;
    thing.probability = 1;
    thing.position_plan =
        Eigen::Vector3d(door.middle_plan.x(), door.middle_plan.y(), 1);  // a handle's height
    const bool leads_here = location.room && door.joins(*location.room);
    thing.room = leads_here ? location.room : goal.room;
  }
  return things;
}

std::vector<guide::Prompt> where_is(const service::Ask& ask, const Situation& situation,
                                    const guide::Wording& wording, TimestampNs now_ns) {
  const std::string asked = name_asked_for(ask);
  const HomeView& home = situation.home;
  const guide::UserLocation location = standing_of(situation.result);
  if (const ViewedSpot* const spot = spot_asked_for(ask, home, wording.phrases())) {
    return guide::where_prompts(spot->thing.name, location, {&spot->thing, 1}, doorways_of(home),
                                home.concepts.vocabulary, wording, now_ns, situation.today);
  }
  if (auto none = no_door(ask, home, wording, now_ns)) return {*std::move(none)};
  if (auto none = none_in_room(ask, home, wording, now_ns)) return {*std::move(none)};
  const auto doors = doors_asked_for(ask, home, wording.phrases());
  const auto things = doors && !doors->empty() ? as_things(*doors, location)
                                               : things_asked_for(ask, home, wording.phrases());
  return guide::where_prompts(asked, location, things, doorways_of(home), home.concepts.vocabulary,
                              wording, now_ns, situation.today);
}

std::optional<guide::Side> side_of(service::Question question) {
  switch (question) {
    case service::Question::kWhatIsLeft:
      return guide::Side::kLeft;
    case service::Question::kWhatIsRight:
      return guide::Side::kRight;
    case service::Question::kWhatIsBehind:
      return guide::Side::kBehind;
    default:
      return std::nullopt;
  }
}

// Of questions that rest on the picture in hand: directions, and where one stands.
bool rests_on_picture(const service::Ask& ask) {
  using service::Question;
  return ask.question == Question::kWhichWay || ask.question == Question::kWhatIsAhead ||
         side_of(ask.question).has_value() ||
         (ask.question == Question::kDescribeRoom && ask.subject.empty());
}

// What the map of the home answers.
class HomeAnswers {
 public:
  HomeAnswers(const Situation& situation, const guide::Wording& wording, TimestampNs now_ns)
      : situation_(situation),
        wording_(wording),
        location_(standing_of(situation.result)),
        doorways_(doorways_of(situation.home)),
        map_(map_of(situation.home, doorways_)),
        today_{now_ns, situation.today} {}

  [[nodiscard]] std::vector<guide::Prompt> to(const service::Ask& ask) const {
    using service::Question;
    const HomeView& home = situation_.home;
    if (rests_on_picture(ask) && situation_.result == nullptr) {
      return {no_picture(situation_.had_pictures, wording_, situation_.now_t_ms)};
    }
    if (const auto side = side_of(ask.question)) return on_side(*side);
    switch (ask.question) {
      case Question::kWhatIsOn:
        return on(ask.subject);
      case Question::kWhatIsAhead:
        return guide::ahead_prompts(map_, location_, {situation_.result->has_depth, obstacle_m()},
                                    wording_, today_);
      case Question::kWhichWay:
        return guide::facing_prompts(map_, location_, wording_, today_);
      case Question::kWhatChanged:
        return guide::change_prompts(home.latest, wording_, today_);
      case Question::kWhichRooms:
        return which_rooms();
      case Question::kWhereToSit:
        return guide::seat_prompts(location_, home.things, doorways_, home.concepts.vocabulary,
                                   wording_, today_.now_ns, today_.date);
      default:
        return of_room(ask);
    }
  }

 private:
  [[nodiscard]] std::optional<double> obstacle_m() const {
    const auto& obstacle = situation_.result->obstacle;
    return obstacle ? std::optional(obstacle->ahead_left_m.x()) : std::nullopt;
  }
  [[nodiscard]] std::vector<guide::Prompt> on(const std::string& asked) const {
    const HomeView& home = situation_.home;
    const auto surface =
        guide::thing_meant(asked, home.things, home.concepts.vocabulary, wording_.phrases());
    if (!surface) return unknown(guide::thing(asked));
    return guide::on_prompts(*surface, map_, location_, wording_, today_);
  }
  // Things, and doors of this room.
  [[nodiscard]] std::vector<guide::Prompt> on_side(guide::Side side) const {
    std::vector<rooms::Doorway> doors = guide::doors_of(doorways_);
    std::erase_if(doors, [&](const rooms::Doorway& door) {
      return !location_.room || !door.joins(*location_.room);
    });
    std::vector<guide::KnownThing> things = as_things(doors, location_);
    things.insert(things.end(), situation_.home.things.begin(), situation_.home.things.end());
    return guide::side_prompts(side, location_, things, wording_, today_.now_ns, today_.date);
  }
  [[nodiscard]] std::vector<guide::Prompt> which_rooms() const {
    std::vector<std::string> names;
    for (const rooms::Room& room : situation_.home.rooms) names.push_back(room.name);
    return guide::rooms_prompts(names, wording_, today_);
  }
  // Where it is, what is in it, or how it is.
  [[nodiscard]] std::vector<guide::Prompt> of_room(const service::Ask& ask) const {
    if (ask.subject.empty() && !location_.room) {
      return {unavailable("route.no_place", wording_, situation_.now_t_ms)};
    }
    const std::string asked = ask.subject.empty() ? *location_.room : ask.subject;
    const auto room = room_meant(asked, situation_.home, wording_.phrases());
    if (!room) return unknown(guide::room(asked));
    switch (ask.question) {
      case service::Question::kWhatIsIn:
        return guide::in_prompts(*room, map_, wording_, today_);
      case service::Question::kDescribeRoom:
        return guide::describe_prompts(*room, map_, location_, wording_, today_);
      default:
        return guide::room_way_prompts(*room, map_, location_, wording_, today_);
    }
  }
  [[nodiscard]] std::vector<guide::Prompt> unknown(const guide::Nouns& name) const {
    const guide::Understood heard{guide::Understood::Outcome::kUnknownName,
                                  guide::QuestionType::kNamed, name};
    return guide::refusal_prompts(heard, names_in(situation_.home), wording_, today_.now_ns);
  }

  const Situation& situation_;
  const guide::Wording& wording_;
  guide::UserLocation location_;
  std::vector<rooms::Doorway> doorways_;
  guide::HomeMap map_;
  guide::Today today_;
};

std::optional<service::GuideWish> wish_of(guide::QuestionType type) {
  using guide::QuestionType;
  switch (type) {
    case QuestionType::kPause:
      return service::GuideWish::kPause;
    case QuestionType::kResume:
      return service::GuideWish::kResume;
    case QuestionType::kHowFar:
      return service::GuideWish::kHowFar;
    case QuestionType::kNext:
      return service::GuideWish::kNext;
    case QuestionType::kBlocked:
      return service::GuideWish::kBlocked;
    case QuestionType::kEnd:
      return service::GuideWish::kEnd;
    default:
      return std::nullopt;
  }
}

// Of what is no wish to a guide; absent for a "yes" to nothing.
std::optional<service::Question> question_of(guide::QuestionType type, bool is_room) {
  using guide::QuestionType;
  using service::Question;
  switch (type) {
    case QuestionType::kWhereAmI:
      return Question::kWhereAmI;
    case QuestionType::kAroundMe:
      return Question::kAroundMe;
    case QuestionType::kWhereIs:
      return Question::kWhereIs;
    case QuestionType::kWayTo:
      return Question::kWayTo;
    case QuestionType::kTakeMeTo:
    case QuestionType::kTakeMeOut:
      return Question::kTakeMeTo;
    case QuestionType::kWhatIsOn:
      return Question::kWhatIsOn;
    case QuestionType::kWhatIsIn:
      return Question::kWhatIsIn;
    case QuestionType::kWhichRooms:
      return Question::kWhichRooms;
    case QuestionType::kWhichWay:
      return Question::kWhichWay;
    case QuestionType::kWhatIsAhead:
    case QuestionType::kSomethingAhead:
      return Question::kWhatIsAhead;
    case QuestionType::kWhatIsLeft:
      return Question::kWhatIsLeft;
    case QuestionType::kWhatIsRight:
      return Question::kWhatIsRight;
    case QuestionType::kWhatIsBehind:
      return Question::kWhatIsBehind;
    case QuestionType::kWhereToSit:
      return Question::kWhereToSit;
    case QuestionType::kWhatChanged:
      return Question::kWhatChanged;
    case QuestionType::kDescribeRoom:
      return Question::kDescribeRoom;
    case QuestionType::kRepeat:
      return Question::kRepeat;
    case QuestionType::kWhatCanIAsk:
      return Question::kWhatCanIAsk;
    case QuestionType::kTeachThing:
      return Question::kTeachThing;
    case QuestionType::kForgetThing:
      return Question::kForgetThing;
    case QuestionType::kShareThing:
      return Question::kShareThing;
    case QuestionType::kKeepThing:
      return Question::kKeepThing;
    case QuestionType::kMarkSpot:
      return Question::kMarkSpot;
    case QuestionType::kTakeMeBack:
      return Question::kTakeMeBack;
    case QuestionType::kWhichSpots:
      return Question::kWhichSpots;
    case QuestionType::kForgetSpot:
      return Question::kForgetSpot;
    case QuestionType::kWhoIsHere:
      return Question::kWhoIsHere;
    case QuestionType::kIsItLight:
      return Question::kIsItLight;
    case QuestionType::kShowWalks:
      return Question::kShowWalks;
    case QuestionType::kHideWalks:
      return Question::kHideWalks;
    case QuestionType::kNamed:  // a room is told of, a thing is looked for
      return is_room ? Question::kDescribeRoom : Question::kWhereIs;
    default:
      return std::nullopt;
  }
}

// Whether who asks for a thing names a room, and nothing else.
bool means_room(const service::Ask& ask, const HomeView& home, const guide::Phrasebook& phrases) {
  return !ask.is_way_out && ask.in_room.empty() && spot_asked_for(ask, home, phrases) == nullptr &&
         !doors_asked_for(ask, home, phrases) &&
         !guide::thing_meant(ask.subject, home.things, home.concepts.vocabulary, phrases) &&
         room_meant(ask.subject, home, phrases);
}

// A room that is known by its photos alone is not.
bool is_on_map(const guide::UserLocation& location, const HomeView& home) {
  if (location.sure_pose() != nullptr || !location.room) return true;
  return home.layout &&
         std::ranges::any_of(home.layout->rooms(), [&](const rooms::RoomExtent& extent) {
           return extent.name == *location.room && extent.floor_m2 > 0;
         });
}

}  // namespace

guide::HomeNames names_in(const HomeView& home) {
  guide::HomeNames names;
  std::set<std::string> things;
  for (const guide::KnownThing& thing : home.things) things.insert(thing.name);
  names.things.assign(things.begin(), things.end());
  for (const rooms::Room& room : home.rooms) names.rooms.push_back(room.name);
  if (!guide::doors_of(doorways_of(home)).empty()) names.goals = {"door"};
  names.goals.emplace_back(
      guide::kNameOfWayOut);  // who asks where none is known hears how to mend it
  for (const ViewedSpot& spot : home.spots) {
    const bool is_named = spot.thing.name == spot.stored.name;
    (is_named ? names.spots : names.goals).push_back(spot.thing.name);
  }
  names.vocabulary = &home.concepts.vocabulary;
  return names;
}

std::optional<service::Ask> ask_of(const guide::Understood& heard, const service::Ask& in_words) {
  if (heard.outcome != guide::Understood::Outcome::kQuestion) return std::nullopt;
  const bool is_room = !heard.names.empty() && heard.names.front().kind == guide::Noun::Kind::kRoom;
  service::Ask ask;
  ask.id = in_words.id;
  ask.t_ms = in_words.t_ms;
  if (!heard.names.empty()) ask.subject = heard.names.front().name;
  if (!heard.rooms.empty()) ask.in_room = heard.rooms.front().name;
  if (heard.rooms.size() > 1) ask.to_room = heard.rooms[1].name;
  if (const auto wish = wish_of(heard.type)) {
    ask.question = service::Question::kGuide;
    ask.wish = *wish;
    return ask;
  }
  const auto question = question_of(heard.type, is_room);
  if (!question) return std::nullopt;
  ask.question = *question;
  ask.is_way_out = heard.type == guide::QuestionType::kTakeMeOut;
  ask.is_room = is_room && (ask.question == service::Question::kWhereIs ||
                            ask.question == service::Question::kTakeMeTo);
  return ask;
}

const ViewedSpot* spot_called(const std::string& name, const HomeView& home) {
  const auto found = std::ranges::find_if(
      home.spots, [&](const ViewedSpot& spot) { return spot.thing.name == name; });
  return found == home.spots.end() ? nullptr : &*found;
}

const ViewedSpot* spot_asked_for(const service::Ask& ask, const HomeView& home,
                                 const guide::Phrasebook& phrases) {
  const ViewedSpot* const called = spot_called(name_asked_for(ask), home);
  if (!asks_for_way_out(ask, home, phrases)) return called;
  // One whose walk was forgotten leads nowhere, and must not stand before a way out that is known.
  const auto leads_out = [&](const ViewedSpot& spot) {
    return spot.thing.position_plan && means_way_out(spot.thing.name, phrases);
  };
  if (called != nullptr && leads_out(*called)) return called;
  const auto found = std::ranges::find_if(home.spots, leads_out);
  return found == home.spots.end() ? nullptr : &*found;
}

bool asks_for_way_out(const service::Ask& ask, const HomeView& home,
                      const guide::Phrasebook& phrases) {
  if (ask.is_way_out) return true;
  if (ask.is_room || !means_way_out(ask.subject, phrases)) return false;
  const auto thing =
      guide::thing_meant(ask.subject, home.things, home.concepts.vocabulary, phrases);
  return !thing || *thing == guide::kNameOfWayOut;
}

std::string name_asked_for(const service::Ask& ask) {
  return ask.is_way_out ? guide::kNameOfWayOut : ask.subject;
}

bool means_something(const std::string& name, const HomeView& home, const guide::Wording& wording) {
  const guide::Phrasebook& phrases = wording.phrases();
  return guide::thing_meant(name, home.things, home.concepts.vocabulary, phrases).has_value() ||
         room_meant(name, home, phrases).has_value();
}

std::vector<guide::KnownThing> things_asked_for(const service::Ask& ask, const HomeView& home,
                                                const guide::Phrasebook& phrases) {
  const bool is_way_out = asks_for_way_out(ask, home, phrases);
  std::vector<guide::KnownThing> things;
  const std::string in_room = room_meant(ask.in_room, home, phrases).value_or(ask.in_room);
  for (const guide::KnownThing& thing : home.things) {
    if (!in_room.empty() && thing.room != in_room) continue;
    if (is_way_out && !means_way_out(thing.name, phrases)) continue;
    things.push_back(thing);
    if (is_way_out) things.back().name = guide::kNameOfWayOut;
  }
  return things;
}

std::optional<std::vector<rooms::Doorway>> doors_asked_for(const service::Ask& ask,
                                                           const HomeView& home,
                                                           const guide::Phrasebook& phrases) {
  const bool may_be_door = !ask.is_room && !ask.is_way_out;
  const auto words = phrases.words_for(guide::Noun::Kind::kThing, ask.subject);
  if (!may_be_door || std::ranges::count(words, "door") == 0) return std::nullopt;
  const auto things = things_asked_for(ask, home, phrases);
  const bool is_thing =
      guide::thing_meant(ask.subject, things, home.concepts.vocabulary, phrases).has_value();
  if (is_thing && ask.to_room.empty()) return std::nullopt;
  std::vector<rooms::Doorway> doors = guide::doors_of(doorways_of(home));
  std::erase_if(doors, [&](const rooms::Doorway& door) {
    const auto leads_to = [&](const std::string& room) { return room.empty() || door.joins(room); };
    return !leads_to(ask.in_room) || !leads_to(ask.to_room);
  });
  return doors;
}

std::vector<std::string> doors_to_choose(const service::Ask& ask, const HomeView& home,
                                         const guide::UserLocation& location,
                                         const guide::Wording& wording) {
  const bool is_of_room =
      ask.question == service::Question::kTakeMeTo && !ask.in_room.empty() && ask.to_room.empty();
  if (!is_of_room) return {};
  std::set<std::string> rooms;
  for (const rooms::Doorway& door :
       doors_asked_for(ask, home, wording.phrases()).value_or(std::vector<rooms::Doorway>())) {
    const std::string& other = door.rooms[door.rooms[0] == ask.in_room ? 1 : 0];
    if (other == location.room) return {};
    rooms.insert(other);
  }
  if (rooms.size() < 2 || rooms.size() > kMostChoices) return {};
  return {rooms.begin(), rooms.end()};
}

std::vector<std::string> rooms_to_choose(const service::Ask& ask, const HomeView& home,
                                         const guide::UserLocation& location,
                                         const guide::Wording& wording) {
  const bool is_of_thing = ask.question == service::Question::kTakeMeTo && !ask.is_room &&
                           !ask.is_way_out && ask.in_room.empty() &&
                           spot_called(ask.subject, home) == nullptr;
  if (!is_of_thing) return {};
  const auto meant =
      guide::thing_meant(ask.subject, home.things, home.concepts.vocabulary, wording.phrases());
  std::set<std::string> rooms;
  for (const guide::KnownThing& thing : home.things) {
    if (thing.name != meant) continue;
    if (!thing.room || thing.room == location.room) return {};
    rooms.insert(*thing.room);
  }
  if (rooms.size() < 2 || rooms.size() > kMostChoices) return {};
  return {rooms.begin(), rooms.end()};
}

std::optional<std::string> way_back(const HomeView& home, std::int64_t now_s) {
  constexpr std::int64_t kHalfADay_s = 12 * 60 * 60;
  const ViewedSpot* const remembered = spot_called(guide::kRememberedPlace, home);
  const ViewedSpot* const start = spot_called(guide::kStartingPlace, home);
  const bool is_recent = remembered != nullptr && now_s - remembered->stored.marked_s < kHalfADay_s;
  if (is_recent || (remembered != nullptr && start == nullptr)) return guide::kRememberedPlace;
  return start != nullptr ? std::optional<std::string>(guide::kStartingPlace) : std::nullopt;
}

guide::Wording wording_of(const service::SpeakingSettings& settings) {
  const auto unit = settings.distances == service::Distances::kSteps ? guide::DistanceUnit::kSteps
                                                                     : guide::DistanceUnit::kMetres;
  return {&catalogue(), {spoken_language(settings.language), unit, settings.step_m}};
}

guide::UserLocation standing_of(const FrameResult* result) {
  guide::UserLocation location;
  if (result == nullptr) return location;
  if (result->place) {
    location.pose = result->place->on_floor();
    location.room = result->place->room;
  }
  if (!location.room && result->decision) location.room = result->decision->room();
  return location;
}

std::vector<std::string> names_of_things(const HomeView& home,
                                         const service::SpeakingSettings& settings) {
  const guide::Wording wording = wording_of(settings);
  std::set<std::string> names;
  for (const guide::KnownThing& thing : home.things) {
    names.insert(wording.phrases().called({guide::Noun::Kind::kThing, thing.name}));
  }
  return {names.begin(), names.end()};
}

std::vector<service::ThingInRooms> things_in_rooms(const HomeView& home,
                                                   const service::SpeakingSettings& settings) {
  const guide::Wording wording = wording_of(settings);
  std::map<std::string, std::set<std::string>> rooms_of;  // "": of one it is not known
  for (const guide::KnownThing& thing : home.things) {
    const std::string name = wording.phrases().called({guide::Noun::Kind::kThing, thing.name});
    rooms_of[name].insert(thing.room.value_or(""));
  }
  std::vector<service::ThingInRooms> several;
  for (const auto& [name, rooms] : rooms_of) {
    if (rooms.size() > 1 && !rooms.contains(""))
      several.push_back({name, {rooms.begin(), rooms.end()}});
  }
  return several;
}

guide::Prompt no_picture(bool had_pictures, const guide::Wording& wording, double now_t_ms) {
  return unavailable(had_pictures ? "device.no_new_picture" : "device.no_picture", wording,
                     now_t_ms);
}

guide::Prompt no_map(const guide::Wording& wording, double now_t_ms) {
  return unavailable("device.no_map", wording, now_t_ms);
}

std::vector<guide::Prompt> answer(const service::Ask& ask, const Situation& situation) {
  const guide::Wording wording = wording_of(situation.settings);
  const guide::UserLocation location = standing_of(situation.result);
  // What rests on a picture is true of the moment when it was taken.
  const TimestampNs now_ns =
      nanoseconds(situation.result != nullptr ? situation.result->t_ms : situation.now_t_ms);
  const bool asks_for_place = ask.question == service::Question::kWhereIs ||
                              ask.question == service::Question::kWayTo ||
                              ask.question == service::Question::kTakeMeTo;
  if (asks_for_place && (ask.is_room || means_room(ask, situation.home, wording.phrases()))) {
    return HomeAnswers(situation, wording, now_ns).to(ask);
  }
  switch (ask.question) {
    case service::Question::kWhereAmI:
      return {where_am_i(situation, wording)};
    case service::Question::kAroundMe:
      if (situation.home.walks.empty()) {
        return {unavailable("device.no_map", wording, situation.now_t_ms)};
      }
      if (situation.result == nullptr) {
        return {no_picture(situation.had_pictures, wording, situation.now_t_ms)};
      }
      return guide::around_prompts(location, situation.home.things, wording, now_ns,
                                   situation.today, is_on_map(location, situation.home));
    case service::Question::kWhereIs:
      return where_is(ask, situation, wording, now_ns);
    case service::Question::kTakeMeTo:  // who cannot be led is told
    case service::Question::kWayTo:
      if (spot_asked_for(ask, situation.home, wording.phrases()) != nullptr) {
        return where_is(ask, situation, wording, now_ns);
      }
      return way_to(ask, situation, wording, now_ns);
    case service::Question::kNameRoom:
      return {guide::named_prompt(ask.subject, wording, nanoseconds(situation.now_t_ms))};
    case service::Question::kGuide:
      return {unavailable("guide.not_running", wording, situation.now_t_ms)};
    case service::Question::kRepeat:
      return {unavailable("repeat.nothing", wording, situation.now_t_ms)};
    case service::Question::kWhatCanIAsk:
      return guide::example_prompts(names_in(situation.home), wording, now_ns);
    case service::Question::kInWords:     // was understood before
    case service::Question::kTeachThing:  // these have been done
    case service::Question::kNameThing:
    case service::Question::kStopTeaching:
    case service::Question::kForgetThing:
    case service::Question::kShareThing:
    case service::Question::kKeepThing:
    case service::Question::kMarkSpot:
    case service::Question::kWhichSpots:
    case service::Question::kForgetSpot:
    case service::Question::kRenameSpot:
    case service::Question::kWhoIsHere:
    case service::Question::kIsItLight:
    case service::Question::kShowWalks:
    case service::Question::kHideWalks:
      break;
    case service::Question::kTakeMeBack:  // there is no way back
      return {guide::spot_prompt(guide::SpotStep::kNoWayBack, "", wording, now_ns)};
    case service::Question::kWhatIsOn:
    case service::Question::kWhatIsIn:
    case service::Question::kWhichRooms:
    case service::Question::kWhichWay:
    case service::Question::kWhatIsAhead:
    case service::Question::kWhatIsLeft:
    case service::Question::kWhatIsRight:
    case service::Question::kWhatIsBehind:
    case service::Question::kWhereToSit:
    case service::Question::kWhatChanged:
    case service::Question::kDescribeRoom:
      return HomeAnswers(situation, wording, now_ns).to(ask);
  }
  return {};
}

bool Announcer::is_obstacle_news(const FrameResult& result, bool is_named) {
  using Side = guide::ObstacleAhead::Side;
  constexpr double kToldFor_s = 1.5;  // with each picture, so that it is heard if one is lost
  constexpr double kAgain_s = 12;     // who stands there hears whole sentences in between
  constexpr double kGone_s = 2;
  constexpr double kNearer_m = 0.25;
  const double t_s = result.t_ms / 1000;
  const double distance_m = result.obstacle->ahead_left_m.x();
  const Side side = result.obstacle->side;
  const bool is_new = !obstacle_ || t_s - obstacle_->seen_s > kGone_s || t_s < obstacle_->told_s ||
                      t_s - obstacle_->told_s > kAgain_s ||
                      distance_m < obstacle_->told_m - kNearer_m ||
                      (obstacle_->was_named && !is_named) ||
                      (obstacle_->side != Side::kAhead && obstacle_->side != side);
  if (is_new) obstacle_ = Obstacle{t_s, t_s, distance_m, side, is_named};
  obstacle_->seen_s = t_s;
  return t_s - obstacle_->told_s < kToldFor_s;
}

std::vector<guide::Prompt> Announcer::after(const Situation& situation, bool tells_obstacles) {
  std::vector<guide::Prompt> prompts;
  const FrameResult& result = *situation.result;
  if (!tells_obstacles) {
    obstacle_.reset();
  } else if (result.obstacle) {
    const guide::KnownThing* const thing = sure_thing_ahead(situation);
    if (is_obstacle_news(result, thing != nullptr)) {
      prompts.push_back(guide::hazard_prompt(
          *result.obstacle, thing, wording_of(situation.settings), nanoseconds(result.t_ms)));
    }
  }
  const auto decision = decision_of(result, situation.home);
  if (!decision) return prompts;
  const std::string before = std::exchange(room_now_, decision->room().value_or(""));
  // Two looks must agree: one may fall on a mirror, or through a door.
  const bool is_certain = !room_now_.empty() && room_now_ == before;
  if (!is_certain || room_now_ == room_called_) return prompts;
  // Nothing where it is not sure enough to be said unasked; a later look may be.
  if (auto prompt = guide::entered_prompt(*decision, wording_of(situation.settings),
                                          nanoseconds(result.t_ms))) {
    room_called_ = room_now_;
    prompts.push_back(*std::move(prompt));
  }
  return prompts;
}

void Announcer::answered(const Situation& situation, const std::vector<guide::Prompt>& prompts) {
  const bool names_the_room =
      std::ranges::any_of(prompts, [](const auto& one) { return one.message_id == "room.is"; });
  if (!names_the_room || situation.result == nullptr) return;
  if (const auto decision = decision_of(*situation.result, situation.home)) {
    room_called_ = decision->room().value_or(room_called_);
  }
}

}  // namespace roomwise::live
