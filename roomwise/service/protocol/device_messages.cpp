#include "roomwise/base/in_context.h"
#include "roomwise/service/protocol/json_members.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::service {
namespace {

constexpr std::array<Word<DeviceKind>, 3> kKinds{{{"phone", DeviceKind::kPhone},
                                                  {"wearable", DeviceKind::kWearable},
                                                  {"page", DeviceKind::kPage}}};
constexpr std::array<Word<Distances>, 2> kDistances{
    {{"metres", Distances::kMetres}, {"steps", Distances::kSteps}}};
constexpr std::array<Word<Question>, 36> kQuestions{{{"where_am_i", Question::kWhereAmI},
                                                     {"around_me", Question::kAroundMe},
                                                     {"where_is", Question::kWhereIs},
                                                     {"way_to", Question::kWayTo},
                                                     {"repeat", Question::kRepeat},
                                                     {"name_room", Question::kNameRoom},
                                                     {"take_me_to", Question::kTakeMeTo},
                                                     {"guide", Question::kGuide},
                                                     {"in_words", Question::kInWords},
                                                     {"what_is_on", Question::kWhatIsOn},
                                                     {"what_is_in", Question::kWhatIsIn},
                                                     {"which_rooms", Question::kWhichRooms},
                                                     {"which_way", Question::kWhichWay},
                                                     {"what_is_ahead", Question::kWhatIsAhead},
                                                     {"what_is_left", Question::kWhatIsLeft},
                                                     {"what_is_right", Question::kWhatIsRight},
                                                     {"what_is_behind", Question::kWhatIsBehind},
                                                     {"where_to_sit", Question::kWhereToSit},
                                                     {"what_changed", Question::kWhatChanged},
                                                     {"describe_room", Question::kDescribeRoom},
                                                     {"what_can_i_ask", Question::kWhatCanIAsk},
                                                     {"teach_thing", Question::kTeachThing},
                                                     {"name_thing", Question::kNameThing},
                                                     {"stop_teaching", Question::kStopTeaching},
                                                     {"forget_thing", Question::kForgetThing},
                                                     {"share_thing", Question::kShareThing},
                                                     {"keep_thing", Question::kKeepThing},
                                                     {"mark_spot", Question::kMarkSpot},
                                                     {"take_me_back", Question::kTakeMeBack},
                                                     {"which_spots", Question::kWhichSpots},
                                                     {"forget_spot", Question::kForgetSpot},
                                                     {"rename_spot", Question::kRenameSpot},
                                                     {"who_is_here", Question::kWhoIsHere},
                                                     {"is_it_light", Question::kIsItLight},
                                                     {"show_walks", Question::kShowWalks},
                                                     {"hide_walks", Question::kHideWalks}}};
constexpr std::array<Word<GuideWish>, 6> kWishes{{{"pause", GuideWish::kPause},
                                                  {"resume", GuideWish::kResume},
                                                  {"how_far", GuideWish::kHowFar},
                                                  {"next", GuideWish::kNext},
                                                  {"blocked", GuideWish::kBlocked},
                                                  {"end", GuideWish::kEnd}}};

// What is asked for by no name.
enum class Goal : std::uint8_t { kWayOut };
constexpr std::array<Word<Goal>, 1> kGoals{{{"way_out", Goal::kWayOut}}};

constexpr int kMaxSide_px = 4096;

Expected<DeviceCamera> read_camera(const OrderedJson& json) {
  Members members(json);
  DeviceCamera camera;
  camera.width = static_cast<int>(members.integer("width", 1, kMaxSide_px));
  camera.height = static_cast<int>(members.integer("height", 1, kMaxSide_px));
  camera.has_depth = members.has("depth_units_per_metre");
  if (members.has("fx") || camera.has_depth) {
    geometry::PinholeCamera pinhole;
    pinhole.width = camera.width;
    pinhole.height = camera.height;
    pinhole.fx = members.number("fx", 1e-3, 1e6);
    pinhole.fy = members.number("fy", 1e-3, 1e6);
    pinhole.cx = members.number("cx", -1e6, 1e6);
    pinhole.cy = members.number("cy", -1e6, 1e6);
    if (camera.has_depth) {
      pinhole.depth_units_per_metre = members.number("depth_units_per_metre", 1e-3, 1e6);
    }
    if (members.has("distortion")) {
      const OrderedJson* const lens = members.object("distortion");
      if (lens != nullptr) {
        Members terms(*lens);
        pinhole.distortion = {terms.number("k1", -1e3, 1e3), terms.number("k2", -1e3, 1e3),
                              terms.number("p1", -1e3, 1e3), terms.number("p2", -1e3, 1e3),
                              terms.number("k3", -1e3, 1e3)};
        if (terms.error()) return Unexpected(Error(*terms.error()));
      }
    }
    if (!members.error()) ROOMWISE_RETURN_IF_ERROR(pinhole.validate());
    camera.calibrated = pinhole;
  }
  if (members.has("lens")) camera.lens = members.text("lens");
  return members.finish(std::move(camera));
}

SettingsChange read_settings(Members& members) {
  SettingsChange change;
  if (members.has("language")) change.language = members.text("language", 35);
  if (members.has("distances")) change.distances = members.one_of("distances", kDistances);
  if (members.has("step_m")) change.step_m = members.number("step_m", 0.2, 1.5);
  if (members.has("callouts")) change.callouts = members.boolean("callouts");
  if (members.has("may_watch")) change.may_watch = members.boolean("may_watch");
  return change;
}

Expected<DeviceMessage> read_hello(const OrderedJson& json) {
  Members members(json);
  Hello hello;
  hello.version = static_cast<int>(members.integer("version", 1, 1'000'000));
  hello.name = members.text("name");
  hello.kind = members.one_of("kind", kKinds);
  apply(read_settings(members), hello.settings);
  if (members.has("camera")) {
    if (const OrderedJson* const camera = members.object("camera")) {
      ROOMWISE_TRY(hello.camera, in_context("'camera'", read_camera(*camera)));
    }
  }
  return members.finish<DeviceMessage>(std::move(hello));
}

bool asks_for_thing(const Ask& ask) {
  switch (ask.question) {
    case Question::kWhatIsOn:
    case Question::kNameThing:
    case Question::kForgetThing:
    case Question::kShareThing:
    case Question::kKeepThing:
      return true;
    case Question::kWhereIs:
    case Question::kWayTo:
    case Question::kTakeMeTo:
      return !ask.is_room && !ask.is_way_out;
    default:
      return false;
  }
}

bool asks_for_place(Question question) {
  return question == Question::kWhereIs || question == Question::kWayTo ||
         question == Question::kTakeMeTo;
}

bool asks_for_room(const Ask& ask) {
  return ask.question == Question::kNameRoom || ask.question == Question::kWhatIsIn || ask.is_room;
}

bool asks_for_spot(Question question) {
  return question == Question::kMarkSpot || question == Question::kForgetSpot ||
         question == Question::kRenameSpot;
}

Expected<DeviceMessage> read_ask(const OrderedJson& json) {
  Members members(json);
  Ask ask;
  ask.id = members.integer("id", 0, std::int64_t{1} << 53U);
  ask.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  ask.question = members.one_of("question", kQuestions);
  const bool is_of_place = asks_for_place(ask.question);
  if (is_of_place && members.has("goal"))
    ask.is_way_out = members.one_of("goal", kGoals) == Goal::kWayOut;
  if (ask.is_way_out) return members.finish<DeviceMessage>(std::move(ask));
  if (ask.question == Question::kTakeMeTo) ask.is_room = members.has("room");
  if (ask.question == Question::kWhereIs)
    ask.is_room = members.has("room") && !members.has("thing");
  if (ask.question == Question::kGuide) ask.wish = members.one_of("wish", kWishes);
  if (asks_for_thing(ask)) {
    ask.subject = members.text("thing");
    if (!members.error() && ask.subject.empty()) members.wrong("thing", "not empty");
  }
  // Of a thing there may be several.
  if (is_of_place && !ask.is_room && members.has("in")) {
    ask.in_room = members.text("in");
    if (members.has("to")) ask.to_room = members.text("to");
  }
  const bool may_name_room = ask.question == Question::kDescribeRoom && members.has("room");
  if (asks_for_room(ask) || may_name_room) ask.subject = members.text("room");
  if (ask.question == Question::kInWords) ask.subject = members.text("text", kMaxWordsBytes);
  const bool needs_spot = ask.question == Question::kRenameSpot;
  if (needs_spot || (asks_for_spot(ask.question) && members.has("spot"))) {
    ask.subject = members.text("spot");
  }
  if (needs_spot) ask.name = members.text("name");
  if (ask.question == Question::kNameThing && members.has("private")) {
    ask.is_private = members.boolean("private");
  }
  return members.finish<DeviceMessage>(std::move(ask));
}

}  // namespace

void apply(const SettingsChange& change, SpeakingSettings& settings) {
  if (change.language) settings.language = *change.language;
  if (change.distances) settings.distances = *change.distances;
  if (change.step_m) settings.step_m = *change.step_m;
  if (change.callouts) settings.callouts = *change.callouts;
  if (change.may_watch) settings.may_watch = *change.may_watch;
}

std::string_view to_string(Question question) {
  return word_of(kQuestions, question);
}

Expected<DeviceMessage> read_device_message(std::string_view text) {
  ROOMWISE_TRY(const OrderedJson json, parse_object(text, kMaxTextBytes));
  Members members(json);
  const std::string type = members.text("type");
  if (members.error()) return Unexpected(Error(*members.error()));
  if (type == "hello") return read_hello(json);
  if (type == "ask") return read_ask(json);
  if (type == "settings") return members.finish<DeviceMessage>(read_settings(members));
  if (type == "quiet") return members.finish<DeviceMessage>(Quiet{members.boolean("on")});
  if (type == "watch") return members.finish<DeviceMessage>(Watch{members.boolean("on")});
  return fail("'{}' is no type of a message; expected hello, ask, settings, quiet or watch", type);
}

std::optional<std::int64_t> id_of_ask(std::string_view text) {
  const auto json = parse_object(text, kMaxTextBytes);
  if (!json) return std::nullopt;
  Members members(*json);
  const bool is_ask = members.text("type") == "ask";
  const std::int64_t id = members.integer("id", 0, kMaxInteger);
  return is_ask && !members.error() ? std::optional(id) : std::nullopt;
}

namespace {

void write_settings(const SettingsChange& change, OrderedJson& json) {
  if (change.language) json["language"] = *change.language;
  if (change.distances) json["distances"] = word_of(kDistances, *change.distances);
  if (change.step_m) json["step_m"] = *change.step_m;
  if (change.callouts) json["callouts"] = *change.callouts;
  if (change.may_watch) json["may_watch"] = *change.may_watch;
}

OrderedJson camera_json(const DeviceCamera& camera) {
  OrderedJson json{{"width", camera.width}, {"height", camera.height}};
  if (!camera.lens.empty()) json["lens"] = camera.lens;
  if (!camera.calibrated) return json;
  const geometry::PinholeCamera& pinhole = *camera.calibrated;
  json.update({{"fx", pinhole.fx}, {"fy", pinhole.fy}, {"cx", pinhole.cx}, {"cy", pinhole.cy}});
  if (!pinhole.distortion.is_none()) {
    const geometry::LensDistortion& lens = pinhole.distortion;
    json["distortion"] = {
        {"k1", lens.k1}, {"k2", lens.k2}, {"p1", lens.p1}, {"p2", lens.p2}, {"k3", lens.k3}};
  }
  if (camera.has_depth) json["depth_units_per_metre"] = pinhole.depth_units_per_metre;
  return json;
}

OrderedJson to_json(const Hello& hello) {
  OrderedJson json{{"type", "hello"},
                   {"version", hello.version},
                   {"name", hello.name},
                   {"kind", word_of(kKinds, hello.kind)},
                   {"camera", hello.camera ? camera_json(*hello.camera) : OrderedJson(nullptr)}};
  const SpeakingSettings& all = hello.settings;
  write_settings({all.language, all.distances, all.step_m, all.callouts, all.may_watch}, json);
  return json;
}

OrderedJson to_json(const Ask& ask) {
  OrderedJson json{{"type", "ask"},
                   {"id", ask.id},
                   {"t", ask.t_ms},
                   {"question", word_of(kQuestions, ask.question)}};
  if (asks_for_thing(ask)) json["thing"] = ask.subject;
  if (ask.is_way_out) json["goal"] = word_of(kGoals, Goal::kWayOut);
  if (asks_for_thing(ask) && !ask.in_room.empty()) json["in"] = ask.in_room;
  if (json.contains("in") && !ask.to_room.empty()) json["to"] = ask.to_room;
  if (ask.is_private) json["private"] = true;
  if (ask.question == Question::kGuide) json["wish"] = word_of(kWishes, ask.wish);
  const bool may_name_room = ask.question == Question::kDescribeRoom && !ask.subject.empty();
  if (asks_for_room(ask) || may_name_room) json["room"] = ask.subject;
  if (ask.question == Question::kInWords) json["text"] = ask.subject;
  if (asks_for_spot(ask.question) && !ask.subject.empty()) json["spot"] = ask.subject;
  if (ask.question == Question::kRenameSpot) json["name"] = ask.name;
  return json;
}

OrderedJson to_json(const SettingsChange& change) {
  OrderedJson json{{"type", "settings"}};
  write_settings(change, json);
  return json;
}

OrderedJson to_json(const Quiet& quiet) {
  return {{"type", "quiet"}, {"on", quiet.on}};
}

OrderedJson to_json(const Watch& watch) {
  return {{"type", "watch"}, {"on", watch.on}};
}

}  // namespace

std::string write(const DeviceMessage& message) {
  return dump(std::visit([](const auto& one) { return to_json(one); }, message));
}

}  // namespace roomwise::service
