#include "roomwise/pipeline/edits/room_tables.h"

#include <algorithm>

#include "roomwise/base/in_context.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/rooms/recognition/room_classifier.h"

namespace roomwise::pipeline {
namespace {

using Json = nlohmann::ordered_json;

Json rooms_json(const std::vector<rooms::Room>& rooms) {
  Json json = Json::array();
  for (const rooms::Room& room : rooms) json.push_back({{"name", room.name}, {"type", room.type}});
  return json;
}

Json claims_json(const std::vector<rooms::ObjectClaim>& claims) {
  Json json = Json::array();
  for (const rooms::ObjectClaim& claim : claims) {
    json.push_back(
        {{"object", claim.object}, {"room", claim.room}, {"represents", claim.represents}});
  }
  return json;
}

Json ranges_json(const std::vector<recording::RoomRange>& ranges) {
  Json json = Json::array();
  for (const recording::RoomRange& range : ranges) {
    json.push_back({range.first_frame, range.last_frame, range.room, range.stay});
  }
  return json;
}

// Those of one list that the other has not.
Json only_in(const Json& one, const Json& other) {
  Json only = Json::array();
  for (const Json& element : one) {
    if (std::ranges::find(other, element) == other.end()) only.push_back(element);
  }
  return only;
}

// What a change added and took away; null where nothing.
Json difference(const Json& before, const Json& after) {
  Json added = only_in(after, before), removed = only_in(before, after);
  if (added.empty() && removed.empty()) return nullptr;
  return {{"added", std::move(added)}, {"removed", std::move(removed)}};
}

Expected<void> restore_rooms(home::Home& home, const Json& changed) {
  ROOMWISE_TRY(auto rooms, home.rooms());
  for (const Json& one : changed.at("added")) {
    std::erase_if(rooms, [&](const rooms::Room& room) { return room.name == one.at("name"); });
  }
  for (const Json& one : changed.at("removed")) {
    const rooms::Room room{one.at("name").get<std::string>(), one.at("type").get<std::string>()};
    std::erase_if(rooms, [&](const rooms::Room& known) { return known.name == room.name; });
    rooms.push_back(room);
  }
  return home.replace_rooms(rooms);
}

// So that ranges may name them.
Expected<void> add_missing_rooms(home::Home& home, const Json& changed) {
  ROOMWISE_TRY(auto rooms, home.rooms());
  for (const Json& one : changed.at("removed")) {
    const auto name = one.at("name").get<std::string>();
    if (std::ranges::find(rooms, name, &rooms::Room::name) == rooms.end()) {
      rooms.push_back({name, one.at("type").get<std::string>()});
    }
  }
  return home.replace_rooms(rooms);
}

Expected<void> restore_ranges(home::Home& home, const std::string& changed) {
  ROOMWISE_TRY(const auto before, ranges_before(changed));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    const auto of_walk = before.find(recording.id);
    if (of_walk == before.end()) continue;
    ROOMWISE_RETURN_IF_ERROR(home.replace_room_ranges(recording.id, of_walk->second));
  }
  return {};
}

Expected<void> restore_claims(home::Home& home, const Json& changed) {
  ROOMWISE_TRY(auto claims, object_claims(home));
  for (const Json& one : changed.at("added")) {
    std::erase_if(claims, [&](const rooms::ObjectClaim& claim) {
      return claim.object == one.at("object") && claim.room == one.at("room") &&
             claim.represents == one.at("represents");
    });
  }
  for (const Json& one : changed.at("removed")) {
    rooms::ObjectClaim claim{one.at("object").get<std::string>(), one.at("room").get<std::string>(),
                             one.at("represents").get<bool>()};
    // An object represents one room at most: what somebody said of it meanwhile holds.
    const bool is_said_otherwise = std::ranges::any_of(claims, [&](const auto& known) {
      return claim.represents && known.represents && known.object == claim.object;
    });
    if (!is_said_otherwise) claims.push_back(std::move(claim));
  }
  return store_object_claims(home, claims);
}

// A learned classifier goes on with the new name.
Expected<void> rename_in_classifier(home::Home& home, const std::string& name,
                                    const std::string& new_name) {
  ROOMWISE_TRY(auto record, home.room_classifier());
  if (!record) return {};
  auto classifier = rooms::RoomClassifier::from_bytes(record->classifier);
  if (!classifier) return home.forget_learned_rooms();
  std::vector<std::string> rooms = classifier->rooms();
  std::ranges::replace(rooms, name, new_name);
  Json report = Json::parse(record->report_json, nullptr, false);
  if (report.is_object() && report.contains("rooms")) {
    for (Json& room : report["rooms"]) {
      if (room.is_object() && room.value("room", "") == name) room["room"] = new_name;
    }
    record->report_json = report.dump();
  }
  record->classifier = rooms::RoomClassifier(classifier->network(), rooms, classifier->regression(),
                                             classifier->retrieval())
                           .to_bytes();
  ROOMWISE_RETURN_IF_ERROR(home.put_room_classifier(*record));
  ROOMWISE_TRY(auto pictures, home.visit_pictures());
  for (home::VisitPicture& picture : pictures) {
    if (picture.room == name) picture.room = new_name;
  }
  ROOMWISE_RETURN_IF_ERROR(home.replace_visit_pictures(pictures));
  ROOMWISE_TRY(auto keyframe_rooms, home.keyframe_rooms());
  for (auto& [keyframe, scores] : keyframe_rooms) {
    for (rooms::RoomScore& score : scores) {
      if (score.room == name) score.room = new_name;
    }
  }
  return home.replace_keyframe_rooms(keyframe_rooms);
}

}  // namespace

Expected<RoomTables> read_room_tables(const home::Home& home) {
  RoomTables tables;
  ROOMWISE_TRY(const auto rooms, home.rooms());
  tables.rooms = rooms_json(rooms);
  ROOMWISE_TRY(const auto claims, object_claims(home));
  tables.claims = claims_json(claims);
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording.id));
    tables.ranges[recording.id] = labels.ranges();
  }
  return tables;
}

std::string changed_tables(const RoomTables& before, const RoomTables& after) {
  Json changed = Json::object();
  const Json rooms = difference(before.rooms, after.rooms);
  if (!rooms.is_null()) changed["rooms"] = rooms;
  const Json claims = difference(before.claims, after.claims);
  if (!claims.is_null()) changed["claims"] = claims;
  for (const auto& [recording, ranges] : before.ranges) {
    const auto now = after.ranges.find(recording);
    if (now != after.ranges.end() && now->second != ranges) {
      changed["ranges"][std::to_string(recording)] = ranges_json(ranges);
    }
  }
  return changed.dump();
}

Expected<void> restore_tables(home::Home& home, const std::string& changed) {
  const Json tables = Json::parse(changed, nullptr, false);
  if (!tables.is_object()) {
    return fail("{}: is damaged: what a change of rooms changed cannot be read", home.file());
  }
  try {
    if (tables.contains("rooms"))
      ROOMWISE_RETURN_IF_ERROR(add_missing_rooms(home, tables["rooms"]));
    ROOMWISE_RETURN_IF_ERROR(
        in_context(home.file() + ": is damaged", restore_ranges(home, changed)));
    if (tables.contains("rooms")) ROOMWISE_RETURN_IF_ERROR(restore_rooms(home, tables["rooms"]));
    if (tables.contains("claims")) return restore_claims(home, tables["claims"]);
  } catch (const Json::exception& error) {
    return fail("{}: is damaged: what a change of rooms changed cannot be read: {}", home.file(),
                error.what());
  }
  return {};
}

Expected<void> change_room_ranges(
    home::Home& home,
    const std::function<Expected<void>(home::RecordingId walk, RoomRanges& ranges)>& change) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording.id));
    RoomRanges ranges = labels.ranges();
    ROOMWISE_RETURN_IF_ERROR(change(recording.id, ranges));
    if (ranges == labels.ranges()) continue;
    ROOMWISE_RETURN_IF_ERROR(home.replace_room_ranges(recording.id, ranges));
  }
  return {};
}

Expected<void> change_room_name(home::Home& home, const std::string& name,
                                const std::string& new_name) {
  ROOMWISE_TRY(auto rooms, home.rooms());
  const auto room = std::ranges::find(rooms, name, &rooms::Room::name);
  if (room == rooms.end()) return fail("this home has no room '{}'", name);
  if (std::ranges::find(rooms, new_name, &rooms::Room::name) != rooms.end()) {
    return fail("there is a room '{}' already", new_name);
  }
  // Both names stand until no range has the old one any more.
  rooms.push_back({new_name, room->type});
  ROOMWISE_RETURN_IF_ERROR(home.replace_rooms(rooms));
  ROOMWISE_RETURN_IF_ERROR(
      change_room_ranges(home, [&](auto, RoomRanges& ranges) -> Expected<void> {
        for (recording::RoomRange& range : ranges) {
          if (range.room == name) range.room = new_name;
        }
        return {};
      }));
  ROOMWISE_RETURN_IF_ERROR(rename_in_classifier(home, name, new_name));
  ROOMWISE_RETURN_IF_ERROR(move_object_claims(home, name, new_name));
  ROOMWISE_RETURN_IF_ERROR(rename_where_seen(home, name, new_name));
  std::erase_if(rooms, [&](const rooms::Room& one) { return one.name == name; });
  return home.replace_rooms(rooms);
}

Expected<void> rename_where_seen(home::Home& home, const std::string& name,
                                 const std::string& new_name) {
  ROOMWISE_TRY(const auto things, home.own_things());
  for (const home::OwnThing& thing : things) {
    home::OwnThingSighting seen = thing.last_seen;
    if (seen.room != name) continue;
    seen.room = new_name;
    ROOMWISE_RETURN_IF_ERROR(home.put_own_thing_sighting(thing.id, seen));
  }
  return {};
}

}  // namespace roomwise::pipeline
