#include "roomwise/pipeline/edits/undo_edit.h"

#include <algorithm>
#include <functional>
#include <ranges>

#include "roomwise/pipeline/edits/room_tables.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/rooms/recognition/room_classifier.h"

namespace roomwise::pipeline {
namespace {

Expected<std::vector<StoredEdit>::const_iterator> find_edit(const home::Home& home,
                                                            const std::vector<StoredEdit>& edits,
                                                            home::EditId id) {
  const auto found = std::ranges::find(edits, id, &StoredEdit::id);
  if (found == edits.end()) {
    return fail("{}: has no change {}; roomwise edit list says which there are", home.file(), id);
  }
  return found;
}

// A later change that says something of the same.
const StoredEdit* later_change(std::span<const StoredEdit> edits, const StoredEdit& edit,
                               const HomeThings& things) {
  if (edit.kind == EditKind::kTakeWalk) return nullptr;
  const auto about = [&](home::EditId id) {
    const auto found = things.things_of_edit.find(id);
    return found != things.things_of_edit.end() ? found->second : std::set<std::size_t>{};
  };
  const std::set<std::size_t> own = about(edit.id);
  for (auto later = edits.rbegin(); later != edits.rend() && later->id > edit.id; ++later) {
    if (later->kind == EditKind::kTakeWalk) continue;
    if (is_of_thing(edit.kind) != is_of_thing(later->kind)) continue;
    if (!is_of_thing(edit.kind)) return &*later;
    const bool refers = later->change.thing == edit.id || later->change.double_of == edit.id;
    const std::set<std::size_t> theirs = about(later->id);
    const bool is_same =
        std::ranges::any_of(theirs, [&](std::size_t one) { return own.contains(one); });
    if (refers || is_same) return &*later;
  }
  return nullptr;
}

bool is_on_floor(EditKind kind) {
  return kind >= EditKind::kDivideRoom;
}

// Forgets where people's own things were seen, where that is a room that is none.
Expected<void> forget_sightings(home::Home& home,
                                const std::function<bool(const std::string&)>& is_known) {
  ROOMWISE_TRY(const auto things, home.own_things());
  for (const home::OwnThing& thing : things) {
    home::OwnThingSighting seen = thing.last_seen;
    if (!seen.room || is_known(*seen.room)) continue;
    seen.room.reset();
    ROOMWISE_RETURN_IF_ERROR(home.put_own_thing_sighting(thing.id, seen));
  }
  return {};
}

}  // namespace

std::string why_not_undone(std::span<const StoredEdit> edits, const StoredEdit& edit,
                           const HomeThings& things) {
  if (edit.before.empty()) return "a room was removed for good since; it cannot be undone any more";
  const StoredEdit* const later = later_change(edits, edit, things);
  if (later == nullptr) return {};
  return fmt::format("something later is about the same; undo that first: {} (change {})",
                     describe(*later), later->id);
}

Expected<StoredEdit> undo_edit(home::Home& home, home::EditId id) {
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  ROOMWISE_TRY(const auto found, find_edit(home, edits, id));
  const StoredEdit& edit = *found;
  ROOMWISE_TRY(const HomeThings things, find_home_things(home));
  const std::string why_not = why_not_undone(edits, edit, things);
  if (!why_not.empty()) return fail("{}", why_not);
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    if (edit.kind == EditKind::kRenameRoom) {
      // Also of walks that came since.
      ROOMWISE_RETURN_IF_ERROR(change_room_name(home, edit.change.room, edit.change.old_name));
    } else if (is_of_room(edit.kind)) {
      ROOMWISE_RETURN_IF_ERROR(restore_tables(home, edit.before));
    }
    return home.remove_edit(id);
  }));
  return edit;
}

Expected<bool> has_removed_rooms(const home::Home& home) {
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  return std::ranges::any_of(
      edits, [](const StoredEdit& edit) { return edit.kind == EditKind::kRemoveRoom; });
}

Expected<void> forget_removed_rooms(home::Home& home) {
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  ROOMWISE_TRY(const auto rooms, home.rooms());
  const auto is_known = [&](const std::string& name) {
    return std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end();
  };
  const auto reversed = edits | std::views::reverse;
  const auto newest = std::ranges::find(reversed, EditKind::kRemoveRoom, &StoredEdit::kind);
  if (newest == reversed.end()) return {};
  const auto earlier = static_cast<std::size_t>(reversed.end() - newest) - 1;
  return home.atomically([&]() -> Expected<void> {
    for (std::size_t i = 0; i <= earlier; ++i) {
      StoredEdit edit = edits[i];
      if (edit.kind == EditKind::kTakeWalk) continue;
      EditChange now = edit.change;
      apply_later_room_names(std::span(edits).subspan(i + 1), now);
      // Later changes stay, and call it otherwise themselves.
      apply_later_room_names(std::span(edits).subspan(i + 1, earlier - i), edit.change);
      if (is_of_thing(edit.kind)) {
        if (!is_known(now.room)) edit.change.room.clear();
        ROOMWISE_RETURN_IF_ERROR(home.replace_edit(edit.row()));
        continue;
      }
      // What lies on the floor stays; nothing else is needed to tell of it.
      const bool stays = is_on_floor(edit.kind) && is_known(now.room) &&
                         (now.other_room.empty() || is_known(now.other_room)) &&
                         now.room != now.other_room;
      edit.before.clear();
      ROOMWISE_RETURN_IF_ERROR(stays ? home.replace_edit(edit.row()) : home.remove_edit(edit.id));
    }
    ROOMWISE_RETURN_IF_ERROR(forget_sightings(home, is_known));
    ROOMWISE_RETURN_IF_ERROR(home.owe_erasing());
    ROOMWISE_TRY(const auto records, home.room_classifiers());  // one a network
    for (const home::RoomClassifierRecord& record : records) {
      const auto classifier = rooms::RoomClassifier::from_bytes(record.classifier);
      if (!classifier || !std::ranges::all_of(classifier->rooms(), is_known))
        return home.forget_learned_rooms();
    }
    return {};
  });
}

std::string describe(const StoredEdit& edit) {
  const EditChange& change = edit.change;
  switch (edit.kind) {
    case EditKind::kAddThing:
      return fmt::format("added {}", change.name);
    case EditKind::kRenameThing:
      return change.name == change.old_name
                 ? fmt::format("confirmed {}", change.name)
                 : fmt::format("renamed {} to {}", change.old_name, change.name);
    case EditKind::kNote:
      return change.note.empty() ? fmt::format("took the note off {}", change.old_name)
                                 : fmt::format("noted on {}: {}", change.old_name, change.note);
    case EditKind::kMoveThing:
      return change.room.empty() ? fmt::format("moved {}", change.old_name)
                                 : fmt::format("moved {} to {}", change.old_name, change.room);
    case EditKind::kMergeThings:
      return fmt::format("merged {} with {}", change.old_name, change.name);
    case EditKind::kRemoveThing:
      return fmt::format("removed {}", change.old_name);
    case EditKind::kRenameRoom:
      return fmt::format("renamed room {} to {}", change.old_name, change.room);
    case EditKind::kRoomType:
      return fmt::format("made room {} a {}", change.room, change.type);
    case EditKind::kNameFrames:
      return change.name.empty() ? "named rooms of a walk that was forgotten since"
                                 : fmt::format("named rooms of the walk {}", change.name);
    case EditKind::kRemoveRoom:
      return fmt::format("removed room {}", change.room);
    case EditKind::kTakeWalk:
      return fmt::format("took the walk {} away", change.name);
    case EditKind::kJoinRooms:
      return fmt::format("joined room {} to {}", change.other_room, change.room);
    case EditKind::kDivideRoom:
      return fmt::format("cut {} off room {}", change.other_room, change.room);
    case EditKind::kMoveBorder:
      return fmt::format("moved the border of {} and {}", change.room, change.other_room);
    case EditKind::kDrawRoom:
      return fmt::format("drew room {}", change.room);
    case EditKind::kAddDoor:
      return fmt::format("added a door between {} and {}", change.room, change.other_room);
  }
  return {};
}

}  // namespace roomwise::pipeline
