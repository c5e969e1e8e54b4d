#include "roomwise/rooms/layout/layout_edit.h"

#include <algorithm>
#include <map>
#include <set>

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;

std::int16_t number_of(const std::string& room, std::span<const std::string> names) {
  const auto found = std::ranges::find(names, room);
  return found == names.end() ? kNoRoom : static_cast<std::int16_t>(found - names.begin());
}

// Whose cell it is by an edit that was whose before.
std::int16_t edited(const BorderLine& line, std::span<const std::string> names,
                    const Vector2d& middle, bool, std::int16_t before) {
  const std::int16_t left = number_of(line.left, names), right = number_of(line.right, names);
  if (before < 0 || (before != left && before != right)) return before;
  return line.is_left(middle) ? left : right;
}
std::int16_t edited(const DrawnRoom& drawn, std::span<const std::string> names,
                    const Vector2d& middle, bool is_floor, std::int16_t before) {
  const bool is_taken = (is_floor || before >= 0) && drawn.contains(middle);
  return is_taken ? number_of(drawn.room, names) : before;
}
std::int16_t edited(const AddedDoor&, std::span<const std::string>, const Vector2d&, bool,
                    std::int16_t before) {
  return before;
}

}  // namespace

bool BorderLine::is_left(const Vector2d& point_plan) const {
  const Vector2d along = to_plan - from_plan, to = point_plan - from_plan;
  return along.x() * to.y() - along.y() * to.x() > 0;
}

bool DrawnRoom::contains(const Vector2d& p) const {
  // A ray to the right leaves the outline as often as it enters it, or once more.
  bool is_inside = false;
  for (std::size_t i = 0; i < outline_plan.size(); ++i) {
    const Vector2d& a = outline_plan[i];
    const Vector2d& b = outline_plan[(i + 1) % outline_plan.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const double x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (p.x() < x) is_inside = !is_inside;
  }
  return is_inside;
}

void add_edited_rooms(std::span<const LayoutEdit> edits, NamedWalks& walks) {
  std::vector<std::string> rooms;
  for (const LayoutEdit& edit : edits) {
    if (const auto* line = std::get_if<BorderLine>(&edit)) {
      rooms.push_back(line->left);
      rooms.push_back(line->right);
    }
    if (const auto* drawn = std::get_if<DrawnRoom>(&edit)) rooms.push_back(drawn->room);
  }
  add_rooms(rooms, walks);
}

void add_rooms(std::span<const std::string> rooms, NamedWalks& walks) {
  std::set<std::string> all(walks.names.begin(), walks.names.end());
  all.insert(rooms.begin(), rooms.end());
  if (all.size() == walks.names.size()) return;
  const std::vector<std::string> names(all.begin(), all.end());
  const auto renumber = [&](std::int16_t& room) {
    room = number_of(walks.names[static_cast<std::size_t>(room)], names);
  };
  for (WalkEvidence& one : walks.evidence) renumber(one.room);
  for (Crossing& one : walks.crossings) {
    renumber(one.from);
    renumber(one.to);
  }
  walks.names = names;
}

void apply_edits(const fusion::FloorGrid& grid, const FreeFloor& floor,
                 std::span<const LayoutEdit> edits, std::span<const std::string> names,
                 RoomCells& room_of) {
  for (const LayoutEdit& edit : edits) {
    for (int row = 0; row < grid.rows(); ++row) {
      for (int column = 0; column < grid.columns(); ++column) {
        std::int16_t& room = room_of.at(column, row);
        room = std::visit(
            [&](const auto& one) {
              return edited(one, names, grid.cell_middle_m(column, row), floor.at(column, row) != 0,
                            room);
            },
            edit);
      }
    }
  }
}

}  // namespace roomwise::rooms
