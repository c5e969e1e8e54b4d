#include "roomwise/pipeline/rooms/room_contents.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <set>

#include "roomwise/base/in_context.h"
#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kClaimsSetting = "object_claims";
constexpr std::size_t kTopLabels = 3;  // as the two-frame rule looks at
constexpr double kMinScore = 0.2;      // what is less says little where rooms are recognised, too

// What the network of this fingerprint sees in each key-frame, or the newest that names things.
Expected<std::map<home::KeyframeId, std::set<std::string>>> objects_of_keyframes(
    const home::Home& home, const objects::ObjectVocabulary& vocabulary,
    const std::optional<std::string>& naming_network) {
  std::map<home::KeyframeId, std::set<std::string>> seen;
  ROOMWISE_TRY(const auto networks, home.networks());
  for (const auto& [id, network] : networks | std::views::reverse) {
    if (network.labels.empty()) continue;
    if (naming_network && network.fingerprint != *naming_network) continue;
    ROOMWISE_TRY(const auto predictions, home.predictions(id));
    if (predictions.empty()) continue;  // it has looked at nothing yet
    for (const auto& [keyframe, prediction] : predictions) {
      std::set<std::string>& objects = seen[keyframe];
      for (const objects::ObjectScore& observation :
           objects::top_objects(prediction.scores, network.labels, vocabulary, kTopLabels)) {
        if (observation.score >= kMinScore) objects.insert(observation.object);
      }
    }
    break;
  }
  return seen;
}

Expected<std::vector<rooms::ObjectClaim>> claims_of(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  std::vector<rooms::ObjectClaim> claims;
  try {
    for (const Json& one : json) {
      claims.push_back({one.at("object").get<std::string>(), one.at("room").get<std::string>(),
                        one.at("represents").get<bool>()});
    }
  } catch (const Json::exception& error) {
    return fail("the setting '{}' is damaged: {}", kClaimsSetting, error.what());
  }
  return claims;
}

}  // namespace

Expected<std::vector<rooms::ObjectClaim>> object_claims(const home::Home& home) {
  ROOMWISE_TRY(const auto settings, home.settings());
  const auto stored = settings.find(kClaimsSetting);
  if (stored == settings.end()) return std::vector<rooms::ObjectClaim>{};
  return in_context(home.file(), claims_of(stored->second));
}

Expected<void> store_object_claims(home::Home& home,
                                   const std::vector<rooms::ObjectClaim>& claims) {
  Json json = Json::array();
  for (const rooms::ObjectClaim& claim : claims) {
    json.push_back(
        {{"object", claim.object}, {"room", claim.room}, {"represents", claim.represents}});
  }
  return home.put_setting(kClaimsSetting, json.dump());
}

Expected<void> move_object_claims(home::Home& home, const std::string& room,
                                  const std::optional<std::string>& new_name) {
  ROOMWISE_TRY(auto claims, object_claims(home));
  if (claims.empty()) return {};
  if (!new_name) {
    std::erase_if(claims, [&](const rooms::ObjectClaim& claim) { return claim.room == room; });
  } else {
    for (rooms::ObjectClaim& claim : claims) {
      if (claim.room == room) claim.room = *new_name;
    }
  }
  return store_object_claims(home, claims);
}

Expected<rooms::RoomObjects> room_objects(const home::Home& home,
                                          const std::optional<std::string>& naming_network) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto rooms, rooms_of_keyframes(home));
  ROOMWISE_TRY(const auto seen, objects_of_keyframes(home, concepts.vocabulary, naming_network));
  ROOMWISE_TRY(const auto learned, learned_keyframes(home));
  std::vector<rooms::NamedPicture> pictures;
  for (const auto& [keyframe, objects] : seen) {
    const auto room = rooms.find(keyframe);
    const bool counts = learned.empty() || std::ranges::find(learned, keyframe) != learned.end();
    if (room != rooms.end() && counts) pictures.push_back({room->second, objects});
  }
  ROOMWISE_TRY(auto claims, object_claims(home));
  ROOMWISE_TRY(const auto known, home.rooms());
  std::vector<std::string> names;
  for (const rooms::Room& room : known) names.push_back(room.name);
  return rooms::RoomObjects(pictures, std::move(claims), names);
}

Expected<std::map<std::string, rooms::RoomContents>> room_contents(
    const home::Home& home, const std::optional<HomeLayout>& layout) {
  std::map<std::string, rooms::RoomContents> contents;
  ROOMWISE_TRY(const auto rooms, home.rooms());
  for (const rooms::Room& room : rooms) contents[room.name];
  ROOMWISE_TRY(const KeyframeRooms keyframe_rooms, rooms_of_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const HomeThings things, find_home_things(home));
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (const home::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  const rooms::RoomLayout* const rooms_on_floor = layout ? &layout->layout : nullptr;
  for (const HomeThing& instance : things.things) {
    std::optional<Eigen::Vector3d> middle_plan;
    if (layout)
      middle_plan = middle_on_map(instance, poses.at(instance.keyframe_id), layout->frame);
    const auto room = room_of_thing(middle_plan, instance.keyframe_id, rooms_on_floor,
                                    keyframe_rooms, instance.room);
    if (!room) continue;
    double& probability = contents[*room][instance.name];
    probability = 1 - (1 - probability) * (1 - instance.probability);  // one of them at least
  }
  return contents;
}

Expected<std::map<std::string, std::vector<rooms::TypePosterior>>> classify_room_types(
    const home::Home& home, const std::optional<HomeLayout>& layout) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto rooms, home.rooms());
  ROOMWISE_TRY(const auto contents, room_contents(home, layout));
  std::map<std::string, std::vector<rooms::TypePosterior>> guesses;
  for (const rooms::Room& room : rooms) {
    std::vector<rooms::TypedContents> others;
    for (const rooms::Room& other : rooms) {
      const bool is_example =
          other.name != room.name && concepts.objects_of_room_type.contains(other.type);
      if (is_example) others.push_back({other.type, contents.at(other.name)});
    }
    guesses[room.name] = rooms::classify_room_type(contents.at(room.name), concepts, others);
  }
  return guesses;
}

}  // namespace roomwise::pipeline
