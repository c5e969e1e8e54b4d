#include "roomwise/pipeline/edits/edit_rooms.h"

#include <algorithm>
#include <functional>
#include <map>

#include "roomwise/pipeline/edits/map_extent.h"
#include "roomwise/pipeline/edits/room_tables.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

using Eigen::Vector2d;

StoredEdit edit_by(const EditAuthor& author, EditKind kind) {
  return {.made_s = author.time_s, .made_by = author.name, .kind = kind};
}

// Does `work` and keeps the change with what it changed of the home's tables.
Expected<home::EditId> record(home::Home& home, StoredEdit edit,
                              const std::function<Expected<void>()>& work) {
  home::EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const RoomTables before, read_room_tables(home));
    ROOMWISE_RETURN_IF_ERROR(work());
    ROOMWISE_TRY(const RoomTables after, read_room_tables(home));
    edit.before = changed_tables(before, after);
    ROOMWISE_TRY(id, home.add_edit(edit.row()));
    return {};
  }));
  return id;
}

Expected<void> check_has_room(const home::Home& home, const std::string& name) {
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end()) return {};
  return fail("this home has no room '{}'", name);
}

Expected<void> check_is_new(const home::Home& home, const std::string& name) {
  ROOMWISE_RETURN_IF_ERROR(validate_spoken_name(name));
  ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(name));
  if (!check_has_room(home, name)) return {};
  return fail("there is a room '{}' already", name);
}

Expected<void> add_room(home::Home& home, const std::string& name) {
  ROOMWISE_TRY(auto rooms, home.rooms());
  if (std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end()) return {};
  rooms.push_back({name, name});  // its type, until somebody says otherwise
  return home.replace_rooms(rooms);
}

// Calls the frames of all walks as `room_of` says, of their room and the place of their camera.
// Frames whose place is not known go with the one before them in their room.
Expected<void> rename_frames_by_place(
    home::Home& home, const fusion::GravityAlignedFrame& frame,
    const std::function<std::string(const std::string&, const Vector2d&)>& room_of) {
  return change_room_ranges(home, [&](auto walk, RoomRanges& ranges) -> Expected<void> {
    ROOMWISE_TRY(const auto frames, frames_on_floor(home, walk, frame));
    RoomRanges parts;
    for (const recording::RoomRange& range : ranges) {
      recording::RoomRange part = range;
      bool is_placed = false;
      for (const FrameOnFloor& one : frames) {
        if (one.index < range.first_frame || one.index > range.last_frame) continue;
        const std::string room = room_of(range.room, one.point_plan);
        if (is_placed && room != part.room) {
          part.last_frame = one.index - 1;
          parts.push_back(part);
          part.first_frame = one.index;
          part.last_frame = range.last_frame;
        }
        part.room = room;
        is_placed = true;
      }
      parts.push_back(part);
    }
    if (parts == ranges) return {};
    ranges = std::move(parts);
    number_stays(ranges);
    return {};
  });
}

Expected<std::vector<home::EditPlace>> places_of(const home::Home& home,
                                                 const fusion::GravityAlignedFrame& frame,
                                                 std::span<const Vector2d> points_plan) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::vector<home::EditPlace> places;
  for (const Vector2d& point : points_plan) {
    if (!point.allFinite()) return fail("a point is not made of finite numbers");
    const Eigen::Vector3d place_plan(point.x(), point.y(), 0);
    ROOMWISE_RETURN_IF_ERROR(check_near_map(keyframes, frame, place_plan));
    const Eigen::Vector3d world = frame.world_from_plan(place_plan);
    ROOMWISE_TRY(
        places.emplace_back(),
        place_in(keyframes, 0, {{Eigen::Quaterniond::Identity(), world}, Eigen::Vector3d::Zero()}));
  }
  return places;
}

// How many cells of floor each room has now, and would have by a further edit.
struct FloorShares {
  std::map<std::string, int> now, then;
  int changed = 0;  // cells that would change hands
};
Expected<FloorShares> floor_shares(const home::Home& home, const HomeFloor& floor,
                                   const rooms::LayoutEdit& edit) {
  if (!floor.grid) {
    return fail("the map shows no floor to draw on; walk with the camera tilted down a little");
  }
  ROOMWISE_TRY(const auto layout, find_room_layout(home, floor.frame, *floor.grid));
  if (!layout) return fail("no named place of the walks lies on free floor; name the rooms first");
  std::vector<std::string> names;
  for (const rooms::RoomExtent& room : layout->rooms()) names.push_back(room.name);
  const auto* const drawn = std::get_if<rooms::DrawnRoom>(&edit);
  if (const auto* const line = std::get_if<rooms::BorderLine>(&edit)) {
    for (const std::string& room : {line->left, line->right}) {
      if (!std::ranges::count(names, room)) names.push_back(room);
    }
  } else if (drawn != nullptr && !std::ranges::count(names, drawn->room)) {
    names.push_back(drawn->room);
  }
  rooms::RoomCells cells(floor.grid->columns(), floor.grid->rows(), rooms::kNoRoom);
  rooms::FreeFloor free(floor.grid->columns(), floor.grid->rows(), std::uint8_t{0});
  for (int row = 0; row < floor.grid->rows(); ++row) {
    for (int column = 0; column < floor.grid->columns(); ++column) {
      const auto room = layout->room_of_cell(column, row);
      if (room) cells.at(column, row) = static_cast<std::int16_t>(*room);
      free.at(column, row) = layout->is_floor(column, row) ? 1 : 0;
    }
  }
  const rooms::RoomCells before = cells;
  rooms::apply_edits(*floor.grid, free, std::span(&edit, 1), names, cells);
  FloorShares shares;
  const auto count = [&](std::map<std::string, int>& of, std::int16_t room) {
    if (room >= 0) ++of[names[static_cast<std::size_t>(room)]];
  };
  for (int row = 0; row < floor.grid->rows(); ++row) {
    for (int column = 0; column < floor.grid->columns(); ++column) {
      if (free.at(column, row) == 0) continue;
      count(shares.now, before.at(column, row));
      count(shares.then, cells.at(column, row));
      shares.changed += before.at(column, row) != cells.at(column, row) ? 1 : 0;
    }
  }
  return shares;
}

Expected<void> check_line(const FloorLine& line) {
  if (line.from_plan.allFinite() && line.to_plan.allFinite() && line.from_plan != line.to_plan) {
    return {};
  }
  return fail("a line needs two points that are not the same");
}

// A room whose frames are all called otherwise now, by one name that no room had.
std::map<std::string, std::string> renamed_rooms(
    const std::map<home::RecordingId, std::vector<recording::RoomRange>>& before,
    home::RecordingId walk, const recording::RoomLabels& labels,
    const std::vector<rooms::Room>& rooms) {
  std::map<std::string, std::set<std::string>> called, was;  // by old name, by new one
  for (const recording::RoomRange& range : before.at(walk)) {
    std::uint64_t frames = range.last_frame - range.first_frame + 1;  // without a name now
    for (const recording::RoomRange& now : labels.ranges()) {
      const std::uint64_t first = std::max(now.first_frame, range.first_frame);
      const std::uint64_t last = std::min(now.last_frame, range.last_frame);
      if (first > last) continue;
      frames -= last - first + 1;
      called[range.room].insert(now.room);
      was[now.room].insert(range.room);
    }
    if (frames > 0) called[range.room].insert(std::string());
  }
  for (const auto& [recording, ranges] : before) {
    if (recording == walk) continue;
    for (const recording::RoomRange& range : ranges) called.erase(range.room);
  }
  std::map<std::string, std::string> renamed;
  for (const auto& [room, names] : called) {
    const std::string& name = *names.begin();
    const bool is_known = std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end();
    if (names.size() == 1 && !name.empty() && !is_known && was[name].size() == 1) {
      renamed[room] = name;
    }
  }
  return renamed;
}

// Takes rooms from the list that had frames before and have none any more.
Expected<void> drop_rooms_without_frames(home::Home& home, const RoomTables& before,
                                         const std::set<std::string>& keep) {
  std::set<std::string> without;
  for (const auto& [recording, ranges] : before.ranges) {
    for (const recording::RoomRange& range : ranges) without.insert(range.room);
  }
  ROOMWISE_TRY(const RoomTables now, read_room_tables(home));
  for (const auto& [recording, ranges] : now.ranges) {
    for (const recording::RoomRange& range : ranges) without.erase(range.room);
  }
  for (const std::string& room : keep) without.erase(room);
  if (without.empty()) return {};
  for (const std::string& room : without) {
    ROOMWISE_RETURN_IF_ERROR(move_object_claims(home, room, std::nullopt));
  }
  ROOMWISE_TRY(auto rooms, home.rooms());
  std::erase_if(rooms, [&](const rooms::Room& room) { return without.contains(room.name); });
  return home.replace_rooms(rooms);
}

}  // namespace

Expected<home::EditId> rename_room(home::Home& home, const EditAuthor& author,
                                   const std::string& room, const std::string& new_name) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, room));
  if (room == new_name) return fail("the room is called '{}' already", room);
  ROOMWISE_RETURN_IF_ERROR(check_is_new(home, new_name));
  StoredEdit edit = edit_by(author, EditKind::kRenameRoom);
  edit.change.old_name = room;
  edit.change.room = new_name;
  return record(home, std::move(edit), [&] { return change_room_name(home, room, new_name); });
}

Expected<home::EditId> set_room_type(home::Home& home, const EditAuthor& author,
                                     const std::string& room, const std::string& type) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, room));
  ROOMWISE_RETURN_IF_ERROR(validate_spoken_name(type));
  ROOMWISE_TRY(auto rooms, home.rooms());
  const auto changed = std::ranges::find(rooms, room, &rooms::Room::name);
  if (changed->type == type) return fail("the room {} is a {} already", room, type);
  changed->type = type;
  StoredEdit edit = edit_by(author, EditKind::kRoomType);
  edit.change.room = room;
  edit.change.type = type;
  return record(home, std::move(edit), [&] { return home.replace_rooms(rooms); });
}

void number_stays(std::vector<recording::RoomRange>& ranges) {
  std::ranges::sort(ranges, {}, &recording::RoomRange::first_frame);
  std::map<std::string, int> stays;
  for (recording::RoomRange& range : ranges) range.stay = ++stays[range.room];
}

Expected<void> name_frames(home::Home& home, const EditAuthor& author, home::RecordingId walk,
                           const recording::RoomLabels& labels, const std::set<std::string>& keep) {
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    const auto recording = std::ranges::find(recordings, walk, &home::StoredRecording::id);
    if (recording == recordings.end()) return fail("this home has no recording {}", walk);
    for (const recording::RoomRange& range : labels.ranges()) {
      ROOMWISE_RETURN_IF_ERROR(validate_spoken_name(range.room));
    }
    ROOMWISE_TRY(const RoomTables before, read_room_tables(home));
    ROOMWISE_TRY(const auto rooms, home.rooms());
    for (const auto& [room, name] : renamed_rooms(before.ranges, walk, labels, rooms)) {
      if (!keep.contains(room)) ROOMWISE_RETURN_IF_ERROR(rename_room(home, author, room, name));
    }
    ROOMWISE_TRY(const RoomTables renamed, read_room_tables(home));
    if (renamed.ranges.at(walk) == labels.ranges()) return {};
    StoredEdit edit = edit_by(author, EditKind::kNameFrames);
    edit.change.name = recording->recording.name;
    return record(home, std::move(edit),
                  [&]() -> Expected<void> {
                    ROOMWISE_RETURN_IF_ERROR(name_rooms(home, walk, labels));
                    return drop_rooms_without_frames(home, renamed, keep);
                  })
        .map([](home::EditId) {});
  });
}

Expected<home::EditId> remove_room(home::Home& home, const EditAuthor& author,
                                   const std::string& room) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, room));
  StoredEdit edit = edit_by(author, EditKind::kRemoveRoom);
  edit.change.room = room;
  return record(home, std::move(edit), [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        change_room_ranges(home, [&](auto, RoomRanges& ranges) -> Expected<void> {
          std::erase_if(ranges,
                        [&](const recording::RoomRange& range) { return range.room == room; });
          return {};
        }));
    ROOMWISE_RETURN_IF_ERROR(move_object_claims(home, room, std::nullopt));
    ROOMWISE_TRY(auto rooms, home.rooms());
    std::erase_if(rooms, [&](const rooms::Room& one) { return one.name == room; });
    return home.replace_rooms(rooms);
  });
}

Expected<home::EditId> join_rooms(home::Home& home, const EditAuthor& author,
                                  const std::string& kept, const std::string& joined) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, kept));
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, joined));
  if (kept == joined) return fail("the room {} cannot be joined to itself", kept);
  StoredEdit edit = edit_by(author, EditKind::kJoinRooms);
  edit.change.room = kept;
  edit.change.other_room = joined;
  return record(home, std::move(edit), [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        change_room_ranges(home, [&](auto, RoomRanges& ranges) -> Expected<void> {
          for (recording::RoomRange& range : ranges) {
            if (range.room == joined) range.room = kept;
          }
          number_stays(ranges);
          return {};
        }));
    ROOMWISE_RETURN_IF_ERROR(move_object_claims(home, joined, kept));
    // By an undo they stay in the whole room: which of the two it was is not kept.
    ROOMWISE_RETURN_IF_ERROR(rename_where_seen(home, joined, kept));
    ROOMWISE_TRY(auto rooms, home.rooms());
    std::erase_if(rooms, [&](const rooms::Room& one) { return one.name == joined; });
    return home.replace_rooms(rooms);
  });
}

Expected<home::EditId> divide_room(home::Home& home, const EditAuthor& author,
                                   const HomeFloor& floor, const std::string& room,
                                   const FloorLine& line, const std::string& new_room) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, room));
  ROOMWISE_RETURN_IF_ERROR(check_is_new(home, new_room));
  ROOMWISE_RETURN_IF_ERROR(check_line(line));
  const rooms::BorderLine border{new_room, room, line.from_plan, line.to_plan};
  ROOMWISE_TRY(const FloorShares shares, floor_shares(home, floor, border));
  if (!shares.now.contains(room)) return fail("the map shows no floor of the room {}", room);
  if (!shares.then.contains(new_room) || !shares.then.contains(room)) {
    return fail("the line divides nothing: all floor of the room {} lies on one side of it", room);
  }
  StoredEdit edit = edit_by(author, EditKind::kDivideRoom);
  edit.change.room = room;
  edit.change.other_room = new_room;
  ROOMWISE_TRY(edit.places, places_of(home, floor.frame, std::array{line.from_plan, line.to_plan}));
  return record(home, std::move(edit), [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(add_room(home, new_room));
    return rename_frames_by_place(home, floor.frame,
                                  [&](const std::string& of, const Vector2d& point) {
                                    return of == room && border.is_left(point) ? new_room : of;
                                  });
  });
}

Expected<home::EditId> move_border(home::Home& home, const EditAuthor& author,
                                   const HomeFloor& floor, const std::string& left,
                                   const std::string& right, const FloorLine& line) {
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, left));
  ROOMWISE_RETURN_IF_ERROR(check_has_room(home, right));
  if (left == right) return fail("a room has no border with itself");
  ROOMWISE_RETURN_IF_ERROR(check_line(line));
  const rooms::BorderLine border{left, right, line.from_plan, line.to_plan};
  ROOMWISE_TRY(const FloorShares shares, floor_shares(home, floor, border));
  if (shares.changed == 0) {
    return fail("the line changes nothing: all floor of {} and {} lies where it puts it", left,
                right);
  }
  for (const std::string& room : {left, right}) {
    if (!shares.then.contains(room)) {
      return fail("the line leaves the room {} no floor; join the rooms instead", room);
    }
  }
  StoredEdit edit = edit_by(author, EditKind::kMoveBorder);
  edit.change.room = left;
  edit.change.other_room = right;
  ROOMWISE_TRY(edit.places, places_of(home, floor.frame, std::array{line.from_plan, line.to_plan}));
  return record(home, std::move(edit), [&] {
    return rename_frames_by_place(home, floor.frame,
                                  [&](const std::string& of, const Vector2d& point) {
                                    if (of != left && of != right) return of;
                                    return border.is_left(point) ? left : right;
                                  });
  });
}

Expected<home::EditId> draw_room(home::Home& home, const EditAuthor& author, const HomeFloor& floor,
                                 const std::string& room,
                                 const std::vector<Vector2d>& outline_plan) {
  constexpr std::size_t kFewest = 3, kMost = 100;
  const bool is_new = !check_has_room(home, room);
  if (is_new) ROOMWISE_RETURN_IF_ERROR(check_is_new(home, room));
  if (outline_plan.size() < kFewest || outline_plan.size() > kMost) {
    return fail("an outline needs {} to {} corners, not {}", kFewest, kMost, outline_plan.size());
  }
  StoredEdit edit = edit_by(author, EditKind::kDrawRoom);
  edit.change.room = room;
  ROOMWISE_TRY(edit.places, places_of(home, floor.frame, outline_plan));
  const rooms::DrawnRoom drawn{room, outline_plan};
  ROOMWISE_TRY(const FloorShares shares, floor_shares(home, floor, drawn));
  if (shares.changed == 0) {
    return fail("the outline changes nothing: it holds no floor that is not {}'s already", room);
  }
  for (const auto& [other, cells] : shares.now) {
    if (!shares.then.contains(other)) {
      return fail("the outline leaves the room {} no floor; join the rooms instead", other);
    }
  }
  return record(home, std::move(edit), [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(add_room(home, room));
    return rename_frames_by_place(home, floor.frame,
                                  [&](const std::string& of, const Vector2d& point) {
                                    return drawn.contains(point) ? room : of;
                                  });
  });
}

Expected<home::EditId> add_door(home::Home& home, const EditAuthor& author, const HomeFloor& floor,
                                const std::array<std::string, 2>& rooms,
                                const Vector2d& middle_plan) {
  for (const std::string& room : rooms) ROOMWISE_RETURN_IF_ERROR(check_has_room(home, room));
  if (rooms[0] == rooms[1])
    return fail("a door leads between two rooms, not from {} to itself", rooms[0]);
  StoredEdit edit = edit_by(author, EditKind::kAddDoor);
  edit.change.room = std::min(rooms[0], rooms[1]);
  edit.change.other_room = std::max(rooms[0], rooms[1]);
  ROOMWISE_TRY(edit.places, places_of(home, floor.frame, std::array{middle_plan}));
  return record(home, std::move(edit), [] { return Expected<void>(); });
}

}  // namespace roomwise::pipeline
