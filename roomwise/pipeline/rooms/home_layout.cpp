#include "roomwise/pipeline/rooms/home_layout.h"

#include <algorithm>
#include <map>

#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {
namespace {

// The points of a change on the floor; nothing where the walk that one hung on was forgotten, or it
// lies on a part of the map that is not joined.
std::optional<std::vector<Eigen::Vector2d>> points_on_floor(
    const StoredEdit& edit, std::span<const home::Keyframe> keyframes,
    const fusion::GravityAlignedFrame& frame) {
  std::vector<Eigen::Vector2d> points;
  for (const home::EditPlace& place : edit.places) {
    const auto box = box_world(place, keyframes);
    if (!box || keyframes[*place.keyframe].pose.component != 0) return std::nullopt;
    points.push_back(frame.on_plan(box->center()).head<2>());
  }
  return points;
}

std::optional<rooms::LayoutEdit> on_the_floor(const StoredEdit& edit,
                                              std::span<const home::Keyframe> keyframes,
                                              const fusion::GravityAlignedFrame& frame) {
  const auto points = points_on_floor(edit, keyframes, frame);
  if (!points) return std::nullopt;
  const EditChange& change = edit.change;
  switch (edit.kind) {
    case EditKind::kDivideRoom:
      if (points->size() != 2) return std::nullopt;
      return rooms::BorderLine{change.other_room, change.room, points->front(), points->back()};
    case EditKind::kMoveBorder:
      if (points->size() != 2) return std::nullopt;
      return rooms::BorderLine{change.room, change.other_room, points->front(), points->back()};
    case EditKind::kDrawRoom:
      return rooms::DrawnRoom{change.room, *points};
    case EditKind::kAddDoor:
      if (points->size() != 1) return std::nullopt;
      return rooms::AddedDoor{
          {std::min(change.room, change.other_room), std::max(change.room, change.other_room)},
          points->front()};
    default:
      return std::nullopt;
  }
}

void follow_name(std::string& room, const std::string& from, const std::string& to) {
  if (room == from) room = to;
}

// Rooms in what was said before are called as a later change calls them.
void follow_names(const StoredEdit& edit, std::vector<rooms::LayoutEdit>& edits) {
  const EditChange& change = edit.change;
  const bool is_renamed = edit.kind == EditKind::kRenameRoom;
  if (!is_renamed && edit.kind != EditKind::kJoinRooms) return;
  const std::string& from = is_renamed ? change.old_name : change.other_room;
  for (rooms::LayoutEdit& one : edits) {
    if (auto* line = std::get_if<rooms::BorderLine>(&one)) {
      follow_name(line->left, from, change.room);
      follow_name(line->right, from, change.room);
    } else if (auto* drawn = std::get_if<rooms::DrawnRoom>(&one)) {
      follow_name(drawn->room, from, change.room);
    } else if (auto* door = std::get_if<rooms::AddedDoor>(&one)) {
      for (std::string& room : door->rooms) follow_name(room, from, change.room);
      std::ranges::sort(door->rooms);
    }
  }
  std::erase_if(edits, [](const rooms::LayoutEdit& one) {
    const auto* const door = std::get_if<rooms::AddedDoor>(&one);
    return door != nullptr && door->rooms[0] == door->rooms[1];
  });
}

bool are_known(const rooms::LayoutEdit& edit, std::span<const rooms::Room> rooms) {
  const auto is_known = [&](const std::string& name) {
    return std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end();
  };
  if (const auto* line = std::get_if<rooms::BorderLine>(&edit)) {
    return is_known(line->left) && is_known(line->right);
  }
  if (const auto* drawn = std::get_if<rooms::DrawnRoom>(&edit)) return is_known(drawn->room);
  return std::ranges::all_of(std::get<rooms::AddedDoor>(edit).rooms, is_known);
}

// Lines and outlines give frames to other rooms. Which room a frame was in before, as rooms are
// called now.
class RoomsBeforeEdits {
 public:
  static Expected<RoomsBeforeEdits> of(const home::Home& home,
                                       const fusion::GravityAlignedFrame& frame) {
    RoomsBeforeEdits read;
    ROOMWISE_TRY(const auto edits, stored_edits(home));
    ROOMWISE_TRY(const auto keyframes, home.keyframes());
    ROOMWISE_TRY(const auto rooms, home.rooms());
    for (std::size_t i = edits.size(); i-- > 0;) {
      const bool is_by_name = edits[i].kind == EditKind::kNameFrames;
      const std::span later = std::span(edits).subspan(i + 1);
      Step step;
      if (!is_by_name) {
        auto laid = on_the_floor(edits[i], keyframes, frame);
        if (!laid || std::holds_alternative<rooms::AddedDoor>(*laid)) continue;
        EditChange change = edits[i].change;
        apply_later_room_names(later, change);
        step.rooms = {change.room};
        if (!change.other_room.empty()) step.rooms.push_back(change.other_room);
        // Of a room that was removed since nothing is laid over the floor.
        if (!std::ranges::all_of(step.rooms, [&](const auto& one) { return is_in(rooms, one); }))
          continue;
      }
      ROOMWISE_TRY(auto before, ranges_before(edits[i].before));
      for (auto& [walk, ranges] : before) {
        for (recording::RoomRange& range : ranges) {
          EditChange of_range{.room = range.room};
          apply_later_room_names(later, of_range);
          range.room = is_in(rooms, of_range.room) ? of_range.room : std::string();
        }
        step.before = std::move(ranges);
        read.steps_[walk].push_back(step);
      }
    }
    return read;
  }

  [[nodiscard]] std::string room(home::RecordingId walk, std::uint64_t frame,
                                 std::string now) const {
    const auto steps = steps_.find(walk);
    if (steps == steps_.end() || now.empty()) return now;
    for (const Step& step : steps->second) {
      const auto range = std::ranges::find_if(step.before, [&](const recording::RoomRange& one) {
        return one.first_frame <= frame && frame <= one.last_frame;
      });
      const std::string before = range == step.before.end() ? std::string() : range->room;
      if (before == now) continue;
      const bool is_given = std::ranges::count(step.rooms, now) > 0;
      if (step.rooms.empty() || (is_given && before.empty())) return now;  // somebody named it so
      if (is_given) now = before;
    }
    return now;
  }

 private:
  struct Step {
    std::vector<recording::RoomRange> before;
    std::vector<std::string> rooms;  // that frames were given to; none: somebody named them
  };
  static bool is_in(std::span<const rooms::Room> rooms, const std::string& name) {
    return std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end();
  }
  std::map<home::RecordingId, std::vector<Step>> steps_;  // the newest first
};

Expected<void> check_rooms_are_named(const home::Home& home) {
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (!rooms.empty()) return {};
  return fail("{}: no rooms are named; name them with roomwise rooms name", home.file());
}

}  // namespace

Expected<std::vector<FrameOnFloor>> frames_on_floor(const home::Home& home,
                                                    home::RecordingId recording,
                                                    const fusion::GravityAlignedFrame& frame) {
  ROOMWISE_TRY(const auto frames, walked_frames(home, recording));
  std::vector<FrameOnFloor> on_floor;
  for (const WalkedFrame& one : frames) {
    const Eigen::Vector3d camera_plan = frame.on_plan(one.at_world);
    if (frame.storeys.stairs_at(camera_plan.head<2>())) continue;  // over no floor
    on_floor.push_back({one.index, camera_plan.head<2>()});
  }
  return on_floor;
}

Expected<std::vector<rooms::LayoutEdit>> layout_edits(const home::Home& home,
                                                      const fusion::GravityAlignedFrame& frame) {
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  std::vector<rooms::LayoutEdit> on_floor;
  if (edits.empty()) return on_floor;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const StoredEdit& edit : edits) {
    follow_names(edit, on_floor);
    if (auto laid = on_the_floor(edit, keyframes, frame)) on_floor.push_back(*std::move(laid));
  }
  // A room that was removed since takes what was said of it along.
  ROOMWISE_TRY(const auto rooms, home.rooms());
  std::erase_if(on_floor, [&](const rooms::LayoutEdit& one) { return !are_known(one, rooms); });
  return on_floor;
}

Expected<std::optional<rooms::RoomLayout>> find_room_layout(
    const home::Home& home, const fusion::GravityAlignedFrame& frame, const fusion::FloorGrid& grid,
    const rooms::RoomLayoutOptions& options) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const RoomsBeforeEdits before, RoomsBeforeEdits::of(home, frame));
  std::vector<rooms::WalkedPath> walks;
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording.id));
    ROOMWISE_TRY(const auto frames, frames_on_floor(home, recording.id, frame));
    walks.emplace_back();
    std::optional<std::size_t> storey;
    for (const FrameOnFloor& one : frames) {
      // A path lies on one storey: between two there is no floor that it led over.
      const std::size_t here = frame.storeys.at_plan(one.point_plan);
      if (storey && *storey != here) walks.emplace_back();
      storey = here;
      const recording::RoomRange* const range = labels.find(one.index);
      const std::string room = range != nullptr ? range->room : std::string();
      walks.back().push_back({one.point_plan, room, before.room(recording.id, one.index, room)});
    }
  }
  ROOMWISE_TRY(const auto edits, layout_edits(home, frame));
  ROOMWISE_TRY(rooms::RoomLayout layout, rooms::RoomLayout::make(grid, walks, options, edits));
  for (const fusion::Staircase& stairs : frame.storeys.stairs()) {
    layout.add_stairs(stairs.below_plan, stairs.above_plan);
  }
  if (!layout.has_floor()) return std::nullopt;
  return layout;
}

Expected<HomeLayout> build_home_layout(const home::Home& home,
                                       const rooms::RoomLayoutOptions& options, RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check_rooms_are_named(home));
  ROOMWISE_TRY(HomeFloor floor, find_home_floor(home, run));
  if (!floor.grid) {
    return fail("{}: the map shows no floor; walk with the camera tilted down a little",
                home.file());
  }
  ROOMWISE_TRY(auto layout, find_room_layout(home, floor.frame, *floor.grid, options));
  if (!layout) {
    return fail(
        "{}: no named place of the walk lies on free floor; name the rooms of the walk, or walk "
        "with the camera tilted down a little",
        home.file());
  }
  return HomeLayout{floor.frame, *std::move(floor.grid), *std::move(layout)};
}

Expected<std::optional<HomeLayout>> find_home_layout(const home::Home& home, RunContext& run) {
  std::optional<HomeLayout> none;
  ROOMWISE_TRY(const auto rooms, home.rooms());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  if (rooms.empty() || keyframes.empty()) return none;
  ROOMWISE_TRY(HomeFloor floor, find_home_floor(home, run));
  if (!floor.grid) return none;
  ROOMWISE_TRY(auto layout, find_room_layout(home, floor.frame, *floor.grid));
  if (!layout) return none;
  return HomeLayout{floor.frame, *std::move(floor.grid), *std::move(layout)};
}

}  // namespace roomwise::pipeline
