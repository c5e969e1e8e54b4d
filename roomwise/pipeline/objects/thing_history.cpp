#include "roomwise/pipeline/objects/thing_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "roomwise/objects/changes/changes.h"
#include "roomwise/pipeline/stored/made_from.h"

namespace roomwise::pipeline {
namespace {

using nlohmann::json;

const std::string kHistoryName = "things";
// To be raised where things are followed otherwise than before.
constexpr std::uint64_t kHistoryMethod = 2;

constexpr std::array<std::pair<ThingEvent, std::string_view>, 7> kEvents{
    {{ThingEvent::kFound, "found"},
     {ThingEvent::kNew, "new"},
     {ThingEvent::kThere, "there"},
     {ThingEvent::kMoved, "moved"},
     {ThingEvent::kShifted, "shifted"},
     {ThingEvent::kGone, "gone"},
     {ThingEvent::kUnobserved, "not looked at"}}};

// All that things are followed from: the key-frames and where they are, and which finders looked at
// which of them. What a finder found in a key-frame never changes.
Expected<std::string> history_made_from(const home::Home& home) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto finders, home.region_finders());
  MadeFrom made_from;
  made_from.add(kHistoryMethod);
  made_from.add(std::uint64_t{keyframes.size()});
  made_from.add(keyframes);
  for (const home::Keyframe& one : keyframes) made_from.add(one.pose.component);
  for (const auto& [id, finder] : finders) {
    ROOMWISE_TRY(const auto looked_at, home.looked_at(id));
    made_from.add(finder.fingerprint);
    made_from.add(std::uint64_t{looked_at.size()});
    for (const home::KeyframeId keyframe : looked_at) made_from.add(std::uint64_t{keyframe});
  }
  return made_from.digest();
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

json sighting_json(const Sighting& one) {
  return {{"walk", one.walk}, {"time_ns", one.time_ns}};
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

[[noreturn]] void reject(const char* why) {
  throw json::other_error::create(501, why, nullptr);
}

// Reads what keep_home_history() wrote; throws json::exception on anything else, since a file may
// be damaged.
class HistoryReader {
 public:
  // `keyframes`: of the home, which lie by id.
  explicit HistoryReader(std::span<const home::Keyframe> keyframes) : keyframes_(keyframes.size()) {
    for (const home::Keyframe& one : keyframes) known_walks_.insert(one.recording);
  }

  [[nodiscard]] HomeHistory history(const json& value) const {
    HomeHistory history;
    for (const json& walk : listed(value, "walks")) history.walks.push_back(walk_id(walk));
    for (const json& one : value.at("things")) history.things.push_back(thing_history(one));
    return history;
  }

 private:
  // A list that has one entry or more.
  static const json& listed(const json& value, const char* name) {
    const json& list = value.at(name);
    if (!list.is_array() || list.empty()) reject("a list is empty");
    return list;
  }
  template <typename Number>
  static Number whole(const json& value) {
    if (!value.is_number_integer()) reject("a number is not whole");
    return value.get<Number>();
  }
  template <std::size_t kCount>
  static std::array<double, kCount> numbers(const json& value) {
    const auto numbers = value.get<std::array<double, kCount>>();
    // Pixels are kept as floats.
    constexpr double kLargest = std::numeric_limits<float>::max();
    if (!std::ranges::all_of(numbers, [](double one) { return std::abs(one) <= kLargest; }))
      reject("a number is not finite");
    return numbers;
  }

  [[nodiscard]] home::RecordingId walk_id(const json& value) const {
    const auto id = whole<home::RecordingId>(value);
    if (!known_walks_.contains(id)) reject("the home has no such walk");
    return id;
  }

  [[nodiscard]] objects::Instance instance(const json& value) const {
    objects::Instance one;
    value.at("name").get_to(one.name);
    one.probability = value.at("probability").get<double>();
    if (!(one.probability >= 0 && one.probability <= 1)) reject("a probability is none");
    one.keyframe_id = whole<std::uint64_t>(value.at("keyframe"));
    if (one.keyframe_id >= keyframes_) reject("the home has no such key-frame");
    const auto picture = numbers<4>(value.at("picture_box"));
    one.picture_box = {static_cast<float>(picture[0]), static_cast<float>(picture[1]),
                       static_cast<float>(picture[2]), static_cast<float>(picture[3])};
    const auto n = numbers<10>(value.at("box"));
    one.box_keyframe = {{Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]}},
                        {n[7], n[8], n[9]}};
    return one;
  }

  [[nodiscard]] Sighting sighting(const json& value) const {
    return {walk_id(value.at("walk")), whole<TimestampNs>(value.at("time_ns"))};
  }

  [[nodiscard]] WalkEvent event(const json& value) const {
    WalkEvent event{walk_id(value.at("walk")), event_from(value.at("what").get<std::string>())};
    if (value.contains("from")) event.from = instance(value.at("from"));
    return event;
  }

  [[nodiscard]] ThingHistory thing_history(const json& value) const {
    ThingHistory one{.thing = instance(value.at("thing")),
                     .is_gone = value.at("is_gone").get<bool>(),
                     .first_seen = sighting(value.at("first_seen")),
                     .last_seen = sighting(value.at("last_seen")),
                     .events = {}};
    for (const json& written : listed(value, "events")) one.events.push_back(event(written));
    return one;
  }

  static ThingEvent event_from(const std::string& word) {
    const auto found = std::ranges::find(kEvents, std::string_view(word),
                                         &std::pair<ThingEvent, std::string_view>::second);
    if (found == kEvents.end()) reject("no event is called so");
    return found->first;
  }

  std::uint64_t keyframes_ = 0;
  std::set<home::RecordingId> known_walks_;
};

// What the home keeps of its things as they are now; nothing where it is stale or damaged.
Expected<std::optional<HomeHistory>> kept_history(const home::Home& home) {
  ROOMWISE_TRY(const std::string now, history_made_from(home));
  ROOMWISE_TRY(const auto kept, home.derived_data(kHistoryName));
  if (!kept || kept->made_from != now) return std::nullopt;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  try {
    return HistoryReader(keyframes).history(json::from_cbor(kept->data));
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

// Whether an instance of the home is the thing as it stands.
bool is_of(const ThingHistory& one, const objects::Instance& instance) {
  const network::PixelBox &a = one.thing.picture_box, &b = instance.picture_box;
  return instance.visit == 0 && one.thing.keyframe_id == instance.keyframe_id && a.left == b.left &&
         a.top == b.top && a.right == b.right && a.bottom == b.bottom;
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
  const auto found = std::ranges::find_if(
      things, [&](const ThingHistory& one) { return !one.is_gone && is_of(one, instance); });
  return found == things.end() ? nullptr : &*found;
}

std::vector<ThingChange> HomeHistory::changes_by(home::RecordingId walk) const {
  std::vector<ThingChange> changes;
  for (const ThingHistory& thing : things) {
    for (const WalkEvent& event : thing.events) {
      if (event.walk == walk && is_change(event.what)) changes.push_back({&thing, &event});
    }
  }
  return changes;
}

void HomeHistory::correct(const HomeThings& corrections) {
  std::vector<ThingHistory> corrected;
  for (ThingHistory& one : things) {
    if (one.is_gone) {
      const auto name = corrections.name_of_gone(one.thing);
      if (!name) continue;
      one.thing.name = *name;
    } else {
      const auto stands = std::ranges::find_if(
          corrections.things, [&](const HomeThing& thing) { return is_of(one, thing); });
      if (stands == corrections.things.end()) continue;
      one.thing.name = stands->name;
      one.thing.names = stands->names;
      one.thing.probability = stands->probability;
    }
    corrected.push_back(std::move(one));
  }
  things = std::move(corrected);
}

Expected<HomeHistory> home_history_as_found(const home::Home& home) {
  ROOMWISE_TRY(auto history, kept_history(home));
  if (!history) return follow_things(home);
  return *std::move(history);
}

Expected<HomeHistory> find_home_history(const home::Home& home) {
  ROOMWISE_TRY(const HomeThings things, find_home_things(home));
  return find_home_history(home, things);
}

Expected<HomeHistory> find_home_history(const home::Home& home, const HomeThings& things) {
  ROOMWISE_TRY(HomeHistory history, home_history_as_found(home));
  history.correct(things);
  return history;
}

Expected<void> keep_home_history(home::Home& home) {
  ROOMWISE_TRY(const auto kept, kept_history(home));
  if (kept) return {};
  ROOMWISE_TRY(const HomeHistory history, follow_things(home));
  return keep_home_history(home, history);
}

Expected<void> keep_home_history(home::Home& home, const HomeHistory& history) {
  ROOMWISE_TRY(const std::string now, history_made_from(home));
  json value{{"walks", history.walks}, {"things", json::array()}};
  for (const ThingHistory& one : history.things) value["things"].push_back(history_json(one));
  return home.put_derived_data({kHistoryName, now, json::to_cbor(value)});
}

}  // namespace roomwise::pipeline
