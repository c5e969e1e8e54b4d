#include "roomwise/service/protocol/json_members.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::service {
namespace {

OrderedJson welcome_json(const Welcome& welcome, std::string_view type) {
  OrderedJson in_rooms = OrderedJson::array();
  for (const auto& [thing, rooms] : welcome.things_in_rooms) {
    in_rooms.push_back({{"thing", thing}, {"rooms", rooms}});
  }
  return {{"type", type},
          {"version", kProtocolVersion},
          {"home", welcome.home},
          {"role", welcome.role},
          {"rooms", welcome.rooms},
          {"things", welcome.things},
          {"things_in_rooms", std::move(in_rooms)},
          {"spots", welcome.spots},
          {"sees_rooms", welcome.has_room_classifier},
          {"sees_places", welcome.can_localize},
          {"max_frame_bytes", kMaxFrameBytes}};
}

OrderedJson to_json(const Welcome& welcome) {
  return welcome_json(welcome, "welcome");
}

OrderedJson to_json(const FrameArrived& frame) {
  return {{"type", "frame"}, {"t", frame.t_ms}, {"dropped", frame.dropped}};
}

OrderedJson to_json(const Seen& seen) {
  OrderedJson position;
  if (const auto& at = seen.position) {
    position = {{"x", at->x_m},
                {"y", at->y_m},
                {"z", at->z_m},
                {"heading_degrees", at->heading_degrees},
                {"sigma_m", at->sigma_m}};
  }
  return {{"type", "seen"},
          {"t", seen.t_ms},
          {"verdict", seen.room_decision},
          {"room", seen.room},
          {"probability", seen.probability},
          {"why", seen.why},
          {"position", position}};
}

OrderedJson to_json(const GoalBearing& bearing) {
  return {{"type", "aim"},
          {"t", bearing.t_ms},
          {"bearing_degrees", bearing.bearing_degrees},
          {"distance_m", bearing.distance_m},
          {"valid_until_t", bearing.valid_until_t_ms}};
}

OrderedJson to_json(const PromptMessage& prompt) {
  return {{"type", "prompt"},
          {"answer_to", or_null(prompt.answer_to)},
          {"key", prompt.replace_key},
          {"message", prompt.message_id},
          {"text", prompt.text},
          {"language", prompt.language},
          {"priority", prompt.priority},
          {"confidence", prompt.confidence},
          {"sound", prompt.sound},
          {"because", prompt.because},
          {"based_on_t", or_null(prompt.based_on_t_ms)},
          {"valid_until_t", prompt.valid_until_t_ms}};
}

OrderedJson to_json(const RecordingState& recording) {
  return {{"type", "recording"},    {"device", recording.device}, {"state", recording.state},
          {"name", recording.name}, {"frames", recording.frames}, {"text", recording.text}};
}

OrderedJson to_json(const JobState& job) {
  return {{"type", "job"},      {"kind", job.kind},         {"state", job.state},
          {"stage", job.stage}, {"fraction", job.fraction}, {"left_s", or_null(job.left_s)},
          {"text", job.text},   {"message", job.message},   {"values", OrderedJson(job.values)}};
}

OrderedJson to_json(const DeviceSeen& device) {
  return {{"type", "device"},
          {"device", device.device},
          {"name", device.name},
          {"online", device.online},
          {"seen", device.seen ? to_json(*device.seen) : OrderedJson(nullptr)}};
}

OrderedJson to_json(const WatchedWalk& walk) {
  OrderedJson person;
  if (const auto& at = walk.person) {
    person = {{"t", at->t_ms},
              {"x", at->x_m},
              {"y", at->y_m},
              {"heading_degrees", at->heading_degrees},
              {"sigma_m", at->sigma_m}};
  }
  OrderedJson way = OrderedJson::array();
  for (const Eigen::Vector2d& corner : walk.way) way.push_back({corner.x(), corner.y()});
  OrderedJson said = OrderedJson::array();
  for (const auto& [t_ms, text] : walk.said) said.push_back({{"t", t_ms}, {"text", text}});
  return {{"language", walk.language},
          {"goal", walk.goal},
          {"state", walk.state},
          {"person", person},
          {"left_m", or_null(walk.left_m)},
          {"way", std::move(way)},
          {"said", std::move(said)}};
}

OrderedJson to_json(const WatchedDevice& watched) {
  return {{"type", "led_walk"},
          {"device", watched.device},
          {"name", watched.name},
          {"t", watched.t_ms},
          {"may_watch", watched.may_watch},
          {"walk", watched.walk ? to_json(*watched.walk) : OrderedJson(nullptr)}};
}

OrderedJson to_json(const ErrorMessage& error) {
  return {{"type", "error"},
          {"text", error.text},
          {"answer_to", or_null(error.answer_to)},
          {"t", or_null(error.t_ms)}};
}

Expected<HomeMessage> read_welcome(const OrderedJson& json) {
  Members members(json);
  const std::int64_t version = members.integer("version", 1, 1'000'000);
  if (!members.error() && version != kProtocolVersion) {
    return fail("the computer speaks version {} of the protocol, this device version {}", version,
                kProtocolVersion);
  }
  Welcome welcome;
  welcome.home = members.text("home");
  welcome.role = members.text("role");
  welcome.rooms = members.texts("rooms");
  welcome.things = members.texts("things");
  if (members.has("spots")) welcome.spots = members.texts("spots");
  if (members.has("things_in_rooms")) {
    for (const OrderedJson& one : json.at("things_in_rooms")) {
      Members in_rooms(one);
      welcome.things_in_rooms.push_back({in_rooms.text("thing"), in_rooms.texts("rooms")});
      if (in_rooms.error()) return fail("'things_in_rooms': {}", in_rooms.error()->message);
    }
  }
  welcome.has_room_classifier = members.boolean("sees_rooms");
  welcome.can_localize = members.boolean("sees_places");
  return members.finish<HomeMessage>(std::move(welcome));
}

Expected<HomeMessage> read_arrived(const OrderedJson& json) {
  Members members(json);
  FrameArrived frame;
  frame.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  frame.dropped = static_cast<std::uint64_t>(members.integer("dropped", 0, kMaxInteger));
  return members.finish<HomeMessage>(frame);
}

Expected<Seen> read_seen(const OrderedJson& json) {
  Members members(json);
  Seen seen;
  seen.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  seen.room_decision = members.text("verdict");
  seen.room = members.text("room");
  seen.probability = members.number("probability", 0, 1);
  seen.why = members.text("why", kMaxSentenceBytes);
  if (members.has("position")) {
    if (const OrderedJson* const position = members.object("position")) {
      Members at(*position);
      seen.position = SeenPosition{
          at.number("x", -1e4, 1e4), at.number("y", -1e4, 1e4), at.number("z", -1e4, 1e4),
          at.number("heading_degrees", -360, 360), at.number("sigma_m", 0, 1e4)};
      if (at.error()) return Unexpected(Error(*at.error()));
    }
  }
  return members.finish(std::move(seen));
}

Expected<HomeMessage> read_goal_bearing(const OrderedJson& json) {
  Members members(json);
  GoalBearing bearing;
  bearing.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  bearing.bearing_degrees = members.number("bearing_degrees", -180, 180);
  bearing.distance_m = members.number("distance_m", 0, 1e4);
  bearing.valid_until_t_ms = members.number("valid_until_t", -kMaxTime_ms, kMaxValidUntil_ms);
  return members.finish<HomeMessage>(bearing);
}

Expected<HomeMessage> read_prompt(const OrderedJson& json) {
  Members members(json);
  PromptMessage prompt;
  if (members.has("answer_to")) prompt.answer_to = members.integer("answer_to", 0, kMaxInteger);
  prompt.replace_key = members.text("key", kMaxKeyBytes);
  prompt.message_id = members.text("message");
  prompt.text = members.text("text", kMaxSentenceBytes);
  prompt.language = members.text("language");
  prompt.priority = members.text("priority");
  prompt.confidence = members.text("confidence");
  prompt.sound = members.text("sound");
  prompt.because = members.text("because", kMaxSentenceBytes);
  if (members.has("based_on_t")) {
    prompt.based_on_t_ms = members.number("based_on_t", -kMaxTime_ms, kMaxTime_ms);
  }
  prompt.valid_until_t_ms = members.number("valid_until_t", -kMaxTime_ms, kMaxValidUntil_ms);
  return members.finish<HomeMessage>(std::move(prompt));
}

Expected<HomeMessage> read_recording(const OrderedJson& json) {
  Members members(json);
  RecordingState recording;
  recording.device = members.integer("device", 0, kMaxInteger);
  recording.state = members.text("state");
  recording.name = members.text("name");
  recording.frames = static_cast<std::uint64_t>(members.integer("frames", 0, kMaxInteger));
  recording.text = members.text("text", kMaxSentenceBytes);
  return members.finish<HomeMessage>(std::move(recording));
}

Expected<HomeMessage> read_job(const OrderedJson& json) {
  Members members(json);
  JobState job;
  job.kind = members.text("kind");
  job.state = members.text("state");
  job.stage = members.text("stage");
  job.fraction = members.number("fraction", 0, 1);
  if (members.has("left_s")) job.left_s = members.number("left_s", 0, 1e9);
  job.text = members.text("text", kMaxSentenceBytes);
  job.message = members.text("message");
  if (const OrderedJson* const values = members.object("values")) {
    Members numbers(*values);
    for (const auto& [name, value] : values->items()) {
      job.values[name] = numbers.integer(name.c_str(), 0, kMaxInteger);
    }
    if (numbers.error()) return Unexpected(Error(*numbers.error()));
  }
  return members.finish<HomeMessage>(std::move(job));
}

Expected<HomeMessage> read_device_seen(const OrderedJson& json) {
  Members members(json);
  DeviceSeen device;
  device.device = members.integer("device", 0, kMaxInteger);
  device.name = members.text("name");
  device.online = members.boolean("online");
  if (members.has("seen")) {
    if (const OrderedJson* const seen = members.object("seen")) {
      ROOMWISE_TRY(device.seen, read_seen(*seen));
    }
  }
  return members.finish<HomeMessage>(std::move(device));
}

Expected<WatchedWalk> read_watched_walk(const OrderedJson& json) {
  Members members(json);
  WatchedWalk walk;
  walk.language = members.text("language");
  walk.goal = members.text("goal");
  walk.state = members.text("state");
  if (members.has("person")) {
    if (const OrderedJson* const person = members.object("person")) {
      Members at(*person);
      walk.person = {at.number("t", -kMaxTime_ms, kMaxTime_ms), at.number("x", -1e4, 1e4),
                     at.number("y", -1e4, 1e4), at.number("heading_degrees", -360, 360),
                     at.number("sigma_m", 0, 1e4)};
      if (at.error()) return Unexpected(Error(*at.error()));
    }
  }
  if (members.has("left_m")) walk.left_m = members.number("left_m", 0, 1e4);
  const auto list = [&](const char* name) {
    if (!json.contains(name) || !json.at(name).is_array()) members.wrong(name, "a list");
    return members.error() ? OrderedJson::array() : json.at(name);
  };
  for (const OrderedJson& one : list("way")) {
    const OrderedJson corner{{"corner", one}};
    Members of_way(corner);
    const auto at = of_way.numbers("corner", 2, -1e4, 1e4);
    if (of_way.error()) return fail("'way': {}", of_way.error()->message);
    walk.way.emplace_back(at[0], at[1]);
  }
  for (const OrderedJson& one : list("said")) {
    Members said(one);
    walk.said.push_back(
        {said.number("t", -kMaxTime_ms, kMaxTime_ms), said.text("text", kMaxSentenceBytes)});
    if (said.error()) return fail("'said': {}", said.error()->message);
  }
  return members.finish(std::move(walk));
}

Expected<HomeMessage> read_watched(const OrderedJson& json) {
  Members members(json);
  WatchedDevice watched;
  // Below 0: somebody of the staff (Identity::device_of_account).
  watched.device = members.integer("device", -kMaxInteger, kMaxInteger);
  watched.name = members.text("name");
  watched.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  watched.may_watch = members.boolean("may_watch");
  if (members.has("walk")) {
    if (const OrderedJson* const walk = members.object("walk")) {
      ROOMWISE_TRY(watched.walk, read_watched_walk(*walk));
    }
  }
  return members.finish<HomeMessage>(std::move(watched));
}

Expected<HomeMessage> read_error(const OrderedJson& json) {
  Members members(json);
  ErrorMessage error;
  error.text = members.text("text", kMaxSentenceBytes);
  if (members.has("answer_to")) error.answer_to = members.integer("answer_to", 0, kMaxInteger);
  if (members.has("t")) error.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  return members.finish<HomeMessage>(std::move(error));
}

}  // namespace

std::string write(const HomeMessage& message) {
  return dump(std::visit([](const auto& one) { return to_json(one); }, message));
}

std::string write_home_changed(const Welcome& welcome) {
  return dump(welcome_json(welcome, "home"));
}

Expected<HomeMessage> read_home_message(std::string_view text) {
  ROOMWISE_TRY(const OrderedJson json, parse_object(text, kMaxHomeTextBytes));
  Members members(json);
  const std::string type = members.text("type");
  if (members.error()) return Unexpected(Error(*members.error()));
  if (type == "welcome" || type == "home") return read_welcome(json);
  if (type == "frame") return read_arrived(json);
  if (type == "seen") {
    ROOMWISE_TRY(Seen seen, read_seen(json));
    return HomeMessage(std::move(seen));
  }
  if (type == "aim") return read_goal_bearing(json);
  if (type == "prompt") return read_prompt(json);
  if (type == "recording") return read_recording(json);
  if (type == "job") return read_job(json);
  if (type == "device") return read_device_seen(json);
  if (type == "led_walk") return read_watched(json);
  if (type == "error") return read_error(json);
  return fail("'{}' is no type of a message that this device knows", type);
}

}  // namespace roomwise::service
