#include "roomwise/pipeline/stored/stored_edits.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "roomwise/base/name.h"

namespace roomwise::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<EditKind, std::string_view>, 16> kEditKinds{
    {{EditKind::kAddThing, "add thing"},
     {EditKind::kRenameThing, "rename thing"},
     {EditKind::kNote, "note"},
     {EditKind::kMoveThing, "move thing"},
     {EditKind::kMergeThings, "merge things"},
     {EditKind::kRemoveThing, "remove thing"},
     {EditKind::kRenameRoom, "rename room"},
     {EditKind::kRoomType, "room type"},
     {EditKind::kNameFrames, "name frames"},
     {EditKind::kRemoveRoom, "remove room"},
     {EditKind::kTakeWalk, "take walk away"},
     {EditKind::kJoinRooms, "join rooms"},
     {EditKind::kDivideRoom, "divide room"},
     {EditKind::kMoveBorder, "move border"},
     {EditKind::kDrawRoom, "draw room"},
     {EditKind::kAddDoor, "add door"}}};

constexpr std::array<std::pair<const char*, std::string EditChange::*>, 6> kTexts{
    {{"name", &EditChange::name},
     {"old_name", &EditChange::old_name},
     {"note", &EditChange::note},
     {"room", &EditChange::room},
     {"other_room", &EditChange::other_room},
     {"type", &EditChange::type}}};
constexpr std::array<std::pair<const char*, std::optional<home::EditId> EditChange::*>, 2> kThings{
    {{"thing", &EditChange::thing}, {"double_of", &EditChange::double_of}}};

std::string json_of(const EditChange& change) {
  Json written = Json::object();
  for (const auto& [name, text] : kTexts) {
    if (!(change.*text).empty()) written[name] = change.*text;
  }
  for (const auto& [name, thing] : kThings) {
    if (change.*thing) written[name] = *(change.*thing);
  }
  if (change.walk) written["walk"] = *change.walk;
  return written.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<EditChange> change_of(const std::string& text) {
  const Json written = Json::parse(text, nullptr, false);
  if (!written.is_object()) return std::nullopt;
  EditChange change;
  try {
    for (const auto& [name, to] : kTexts) change.*to = written.value(name, std::string());
    for (const auto& [name, to] : kThings) {
      if (written.contains(name)) change.*to = written.at(name).get<home::EditId>();
    }
    if (written.contains("walk")) change.walk = written.at("walk").get<home::RecordingId>();
  } catch (const Json::exception&) {
    return std::nullopt;
  }
  return change;
}

Expected<void> validate_text(std::string_view what, std::string_view text, std::size_t most) {
  // Characters, not bytes: those that go on with one are not counted.
  const auto characters = std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; });
  if (static_cast<std::size_t>(characters) > most) {
    return fail("{} has {} characters; at most {} can be kept", what, characters, most);
  }
  if (Json(std::string(text)).dump(-1, ' ', false, Json::error_handler_t::ignore) !=
      Json(std::string(text)).dump(-1, ' ', false, Json::error_handler_t::replace)) {
    return fail("{} is not UTF-8 text", what);
  }
  if (!is_legible(text)) {
    return fail("{} has a line break or another sign that cannot be spoken", what);
  }
  return {};
}

// Of what a change was before, the names that it keeps of one walk's frames; whether it had any.
Expected<bool> drop_ranges(const home::Home& home, home::RecordingId walk, home::Edit& edit) {
  if (edit.before.empty()) return false;
  Json before = Json::parse(edit.before, nullptr, false);
  if (!before.is_object()) {
    return fail("{}: is damaged: what change {} changed cannot be read; put back a copy of it",
                home.file(), edit.id);
  }
  const auto ranges = before.find("ranges");
  if (ranges == before.end() || ranges->erase(std::to_string(walk)) == 0) return false;
  edit.before = before.dump();
  return true;
}

// The walk's number may be another's one day, so nothing of its names may come back by it.
Expected<bool> drop_names(const home::Home& home, home::RecordingId walk, home::Edit& edit) {
  ROOMWISE_TRY(const bool had_any, drop_ranges(home, walk, edit));
  if (!had_any || edit.what != to_string(EditKind::kNameFrames)) return had_any;
  auto change = change_of(edit.change);
  if (!change) {
    return fail("{}: is damaged: change {} cannot be read; put back a copy of it", home.file(),
                edit.id);
  }
  change->name.clear();
  edit.change = json_of(*change);
  return true;
}

}  // namespace

std::string_view to_string(EditKind kind) {
  return std::ranges::find(kEditKinds, kind, &std::pair<EditKind, std::string_view>::first)->second;
}

bool is_of_thing(EditKind kind) {
  return kind <= EditKind::kRemoveThing;
}

bool is_of_room(EditKind kind) {
  return !is_of_thing(kind) && kind != EditKind::kTakeWalk;
}

home::Edit StoredEdit::row() const {
  return {.id = id,
          .made_s = made_s,
          .made_by = made_by,
          .what = std::string(to_string(kind)),
          .change = json_of(change),
          .before = before,
          .places = places};
}

Expected<std::vector<StoredEdit>> stored_edits(const home::Home& home) {
  std::vector<StoredEdit> edits;
  ROOMWISE_TRY(auto rows, home.edits());
  for (home::Edit& row : rows) {
    if (row.what == kSpotRow) continue;
    const auto kind = std::ranges::find(kEditKinds, std::string_view(row.what),
                                        &std::pair<EditKind, std::string_view>::second);
    if (kind == kEditKinds.end()) {
      return fail("{}: change {} is of a kind that this Roomwise does not know ('{}'); update it",
                  home.file(), row.id, row.what);
    }
    const auto change = change_of(row.change);
    if (!change) {
      return fail("{}: is damaged: change {} cannot be read; put back a copy of it", home.file(),
                  row.id);
    }
    edits.push_back({row.id, row.made_s, std::move(row.made_by), kind->first, *change,
                     std::move(row.places), std::move(row.before)});
  }
  return edits;
}

std::set<home::RecordingId> walks_taken_away(std::span<const StoredEdit> edits) {
  std::set<home::RecordingId> walks;
  for (const StoredEdit& edit : edits) {
    if (edit.kind == EditKind::kTakeWalk && edit.change.walk) walks.insert(*edit.change.walk);
  }
  return walks;
}

Expected<std::vector<home::StoredRecording>> walks_that_stay(const home::Home& home) {
  ROOMWISE_TRY(auto walks, home.recordings());
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  const std::set<home::RecordingId> taken = walks_taken_away(edits);
  std::erase_if(walks, [&](const home::StoredRecording& one) { return taken.contains(one.id); });
  return walks;
}

Expected<std::map<home::RecordingId, std::vector<recording::RoomRange>>> ranges_before(
    const std::string& before) {
  std::map<home::RecordingId, std::vector<recording::RoomRange>> ranges;
  const Json tables = Json::parse(before, nullptr, false);
  try {
    if (!tables.contains("ranges")) return ranges;
    for (const auto& [walk, of_walk] : tables.at("ranges").items()) {
      auto& read = ranges[static_cast<home::RecordingId>(std::stoull(walk))];
      for (const Json& one : of_walk) {
        read.push_back({one.at(0).get<std::uint64_t>(), one.at(1).get<std::uint64_t>(),
                        one.at(2).get<std::string>(), one.at(3).get<int>()});
      }
    }
  } catch (const std::exception& error) {
    return fail("what a change of rooms changed cannot be read: {}", error.what());
  }
  return ranges;
}

void apply_later_room_names(std::span<const StoredEdit> later, EditChange& change) {
  for (const StoredEdit& edit : later) {
    const bool is_renamed = edit.kind == EditKind::kRenameRoom;
    if (!is_renamed && edit.kind != EditKind::kJoinRooms) continue;
    const std::string& from = is_renamed ? edit.change.old_name : edit.change.other_room;
    for (std::string* const room : {&change.room, &change.other_room}) {
      if (*room == from) *room = edit.change.room;
    }
  }
}

Expected<void> validate_spoken_name(std::string_view name) {
  constexpr std::size_t kMost = 60;
  if (name.find_first_not_of(' ') == std::string_view::npos) {
    return fail("the name is empty; a thing needs a name");
  }
  ROOMWISE_RETURN_IF_ERROR(validate_text("the name", name, kMost));
  if (!is_name(name)) return fail("the name '{}' has no letter and no digit", name);
  return {};
}

Expected<void> validate_note(std::string_view note) {
  constexpr std::size_t kMost = 200;
  return validate_text("the note", note, kMost);
}

home::EditPlace place_of(const objects::Instance& found) {
  return {found.name, found.keyframe_id, found.picture_box, found.box_keyframe};
}

Expected<home::EditPlace> place_in(std::span<const home::Keyframe> keyframes,
                                   std::uint64_t component,
                                   const geometry::OrientedBox& box_world) {
  const home::Keyframe* nearest = nullptr;
  double nearest_m = 0;
  for (const home::Keyframe& one : keyframes) {
    if (one.pose.component != component) continue;
    const double distance_m =
        (one.pose.world_from_keyframe.translation - box_world.center()).norm();
    if (nearest != nullptr && distance_m >= nearest_m) continue;
    nearest = &one;
    nearest_m = distance_m;
  }
  if (nearest == nullptr) return fail("the map is empty: no place on it is known");
  const geometry::RigidTransform keyframe_from_world = nearest->pose.world_from_keyframe.inverse();
  return home::EditPlace{
      {}, nearest->id, {}, {keyframe_from_world * box_world.world_from_box, box_world.size_m}};
}

std::optional<geometry::OrientedBox> box_world(const home::EditPlace& place,
                                               std::span<const home::Keyframe> keyframes) {
  if (!place.keyframe || *place.keyframe >= keyframes.size()) return std::nullopt;
  const geometry::RigidTransform& world_from_keyframe =
      keyframes[*place.keyframe].pose.world_from_keyframe;
  return geometry::OrientedBox{world_from_keyframe * place.box_keyframe.world_from_box,
                               place.box_keyframe.size_m};
}

Expected<void> take_edits_off(home::Home& home, home::RecordingId walk) {
  ROOMWISE_TRY(const auto edits, home.edits());
  if (edits.empty()) return {};
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::vector<home::Keyframe> left;
  std::ranges::copy_if(keyframes, std::back_inserter(left),
                       [&](const home::Keyframe& one) { return one.recording != walk; });
  for (home::Edit edit : edits) {
    if (edit.what == to_string(EditKind::kTakeWalk)) {
      const auto change = change_of(edit.change);
      if (change && change->walk == walk) ROOMWISE_RETURN_IF_ERROR(home.remove_edit(edit.id));
      continue;
    }
    ROOMWISE_TRY(bool is_changed, drop_names(home, walk, edit));
    for (home::EditPlace& place : edit.places) {
      const auto box = box_world(place, keyframes);
      if (!box || keyframes[*place.keyframe].recording != walk) continue;
      const auto moved = place_in(left, keyframes[*place.keyframe].pose.component, *box);
      if (!moved) continue;
      place = {place.name, moved->keyframe, {}, moved->box_keyframe};
      is_changed = true;
    }
    if (is_changed) ROOMWISE_RETURN_IF_ERROR(home.replace_edit(edit));
  }
  return {};
}

}  // namespace roomwise::pipeline
