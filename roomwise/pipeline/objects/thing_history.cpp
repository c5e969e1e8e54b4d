#include "roomwise/pipeline/objects/thing_history.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/base/file.h"
#include "roomwise/objects/changes/changes.h"

namespace roomwise::pipeline {
namespace {

using nlohmann::json;

const std::string kHistoryName = "things";
// To be raised where things are followed otherwise than before.
constexpr int kHistoryMethod = 1;

constexpr std::array<std::pair<ThingEvent, std::string_view>, 7> kEvents{
    {{ThingEvent::kFound, "found"},
     {ThingEvent::kNew, "new"},
     {ThingEvent::kThere, "there"},
     {ThingEvent::kMoved, "moved"},
     {ThingEvent::kShifted, "shifted"},
     {ThingEvent::kGone, "gone"},
     {ThingEvent::kUnobserved, "not looked at"}}};

// Which walks the home holds: what it keeps of others is stale.
Expected<std::string> history_made_from(const home::Home& home) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::string ids = fmt::format("{}", kHistoryMethod);
  for (const home::StoredRecording& one : recordings) ids += fmt::format(" {}", one.id);
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(ids.data()), ids.size()});
}

json instance_json(const objects::Instance& one) {
  const network::PixelBox& picture = one.picture_box;
  const auto& t = one.box_keyframe.world_from_box.translation;
  const auto& q = one.box_keyframe.world_from_box.rotation;
  const auto& size = one.box_keyframe.size_m;
  return {{"name", one.name},
          {"probability", one.probability},
          {"keyframe", one.keyframe_id},
          {"picture_box", {picture.left, picture.top, picture.right, picture.bottom}},
          {"box", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(), size.x(), size.y(), size.z()}}};
}

objects::Instance instance_from(const json& value) {
  objects::Instance one;
  value.at("name").get_to(one.name);
  value.at("probability").get_to(one.probability);
  value.at("keyframe").get_to(one.keyframe_id);
  const auto picture = value.at("picture_box").get<std::array<float, 4>>();
  one.picture_box = {picture[0], picture[1], picture[2], picture[3]};
  const auto n = value.at("box").get<std::array<double, 10>>();
  one.box_keyframe = {{Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]}},
                      {n[7], n[8], n[9]}};
  return one;
}

json sighting_json(const Sighting& one) {
  return {{"walk", one.walk}, {"time_ns", one.time_ns}};
}
Sighting sighting_from(const json& value) {
  return {value.at("walk").get<home::RecordingId>(), value.at("time_ns").get<TimestampNs>()};
}

ThingEvent event_from(const std::string& word) {
  const auto found = std::ranges::find(kEvents, std::string_view(word),
                                       &std::pair<ThingEvent, std::string_view>::second);
  if (found == kEvents.end())
    throw json::other_error::create(501, "no event is called so", nullptr);
  return found->first;
}

json history_json(const ThingHistory& one) {
  json value{{"thing", instance_json(one.thing)},
             {"is_gone", one.is_gone},
             {"first_seen", sighting_json(one.first_seen)},
             {"last_seen", sighting_json(one.last_seen)},
             {"events", json::array()}};
  for (const WalkEvent& event : one.events) {
    json& written = value["events"].emplace_back(
        json{{"walk", event.walk}, {"what", std::string(to_string(event.what))}});
    if (event.from) written["from"] = instance_json(*event.from);
  }
  return value;
}

ThingHistory history_from(const json& value) {
  ThingHistory one{.thing = instance_from(value.at("thing")),
                   .is_gone = value.at("is_gone").get<bool>(),
                   .first_seen = sighting_from(value.at("first_seen")),
                   .last_seen = sighting_from(value.at("last_seen")),
                   .events = {}};
  for (const json& written : value.at("events")) {
    WalkEvent& event = one.events.emplace_back();
    written.at("walk").get_to(event.walk);
    event.what = event_from(written.at("what").get<std::string>());
    if (written.contains("from")) event.from = instance_from(written.at("from"));
  }
  return one;
}

// Nothing where they are not what keep_home_history() wrote.
std::optional<HomeHistory> history_from_bytes(const Bytes& bytes) {
  try {
    const json value = json::from_cbor(bytes);
    HomeHistory history;
    value.at("walks").get_to(history.walks);
    for (const json& one : value.at("things")) history.things.push_back(history_from(one));
    return history;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::string_view to_string(ThingEvent event) {
  return std::ranges::find(kEvents, event, &std::pair<ThingEvent, std::string_view>::first)->second;
}

bool is_change(ThingEvent event) {
  return event == ThingEvent::kNew || event == ThingEvent::kMoved ||
         event == ThingEvent::kShifted || event == ThingEvent::kGone;
}

bool ThingHistory::was_shifted_last() const {
  const auto told = std::ranges::find_if(
      events.rbegin(), events.rend(),
      [](const WalkEvent& event) { return event.what != ThingEvent::kUnobserved; });
  return told != events.rend() && told->what == ThingEvent::kShifted;
}

objects::Instance ThingHistory::as_it_stands() const {
  objects::Instance stands = thing;
  if (was_shifted_last()) {
    stands.sigma_m += Eigen::Vector3d(objects::kShiftSigma_m, objects::kShiftSigma_m, 0);
  }
  return stands;
}

std::optional<double> moved_m(const ThingHistory& thing, const WalkEvent& event,
                              std::span<const home::Keyframe> keyframes) {
  if (!event.from) return std::nullopt;
  // Where the event after it took it from or, after the last, where it stands.
  const objects::Instance* to = &thing.thing;
  for (const WalkEvent* later = &event + 1; later < thing.events.data() + thing.events.size();
       ++later) {
    if (!later->from) continue;
    to = &*later->from;
    break;
  }
  const auto middle = [&](const objects::Instance& one) -> Eigen::Vector3d {
    return one.box_world(keyframes[one.keyframe_id].pose.world_from_keyframe).center();
  };
  return (middle(*to) - middle(*event.from)).norm();
}

const ThingHistory* HomeHistory::of(const objects::Instance& instance) const {
  if (instance.visit != 0) return nullptr;
  const auto found = std::ranges::find_if(things, [&](const ThingHistory& one) {
    const network::PixelBox &a = one.thing.picture_box, &b = instance.picture_box;
    return !one.is_gone && one.thing.keyframe_id == instance.keyframe_id && a.left == b.left &&
           a.top == b.top && a.right == b.right && a.bottom == b.bottom;
  });
  return found == things.end() ? nullptr : &*found;
}

Expected<HomeHistory> find_home_history(const home::Home& home) {
  ROOMWISE_TRY(const std::string now, history_made_from(home));
  ROOMWISE_TRY(const auto kept, home.derived_data(kHistoryName));
  auto history = kept && kept->made_from == now ? history_from_bytes(kept->data) : std::nullopt;
  return history ? *std::move(history) : follow_things(home);
}

Expected<void> keep_home_history(home::Home& home, const HomeHistory& history) {
  ROOMWISE_TRY(const std::string now, history_made_from(home));
  json value{{"walks", history.walks}, {"things", json::array()}};
  for (const ThingHistory& one : history.things) value["things"].push_back(history_json(one));
  return home.put_derived_data({kHistoryName, now, json::to_cbor(value)});
}

}  // namespace roomwise::pipeline
