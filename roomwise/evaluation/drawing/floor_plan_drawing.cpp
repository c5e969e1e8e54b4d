#include "roomwise/evaluation/drawing/floor_plan_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "roomwise/evaluation/drawing/label_space.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;

constexpr double kLongerSide = 1000, kMargin = 30;  // px
constexpr double kLegendRow = 40, kSwatch = 22, kDoorRadius = 9, kLetter = 20, kName = 28;

// The part of the grid that holds rooms.
struct CellBounds {
  int left = 0, right = -1, low = 0, high = -1;  // both ends included
};

CellBounds bounds_of(const FloorPlanView& view) {
  CellBounds bounds{view.room_of_cell.width(), -1, view.room_of_cell.height(), -1};
  for (int row = 0; row < view.room_of_cell.height(); ++row) {
    for (int column = 0; column < view.room_of_cell.width(); ++column) {
      if (view.room_of_cell.at(column, row) < 0) continue;
      bounds = {std::min(bounds.left, column), std::max(bounds.right, column),
                std::min(bounds.low, row), std::max(bounds.high, row)};
    }
  }
  return bounds;
}

std::string cell_look(std::int16_t room, bool is_floor) {
  return fmt::format("class=\"dot-{}\" fill-opacity=\"{}\" shape-rendering=\"crispEdges\"",
                     room % kColors, is_floor ? 0.3 : 0.6);
}
const char* door_look(bool is_walked) {
  return is_walked ? "class=\"object\" style=\"fill:#111111\"" : "class=\"object\"";
}

// Cells of a row that look the same are one rectangle.
void draw_cells(SvgDrawing& drawing, const FloorPlanView& view, const CellBounds& bounds,
                double cell_px, const auto& to_px) {
  const auto look = [&](int column, int row) {
    return std::pair(view.room_of_cell.at(column, row), view.is_floor.at(column, row) != 0);
  };
  for (int row = bounds.low; row <= bounds.high; ++row) {
    for (int begin = bounds.left; begin <= bounds.right;) {
      const auto [room, is_floor] = look(begin, row);
      int end = begin + 1;
      while (end <= bounds.right && look(end, row) == std::pair(room, is_floor)) ++end;
      if (room >= 0) {
        drawing.rectangle(to_px(Vector2d(begin, row + 1)), {cell_px * (end - begin), cell_px},
                          cell_look(room, is_floor));
      }
      begin = end;
    }
  }
}

// The name and the area below it, moved up or down row by row to where there is room for both.
void draw_name(SvgDrawing& drawing, const FloorPlanView::Room& room, const Vector2d& place,
               LabelSpace& space) {
  const std::string area = fmt::format("{:.0f} m²", room.floor_m2);
  const auto box_at = [&](const Vector2d& at) {
    const double half = std::max(LabelSpace::width_of(room.name, kName), 60.0) / 2;
    return LabelSpace::Box{at + Vector2d(-half, -0.8 * kName), at + Vector2d(half, 32)};
  };
  Vector2d at = place;
  for (const int rows : {0, 1, -1, 2, -2, 3, -3, 4, -4}) {
    const Vector2d moved = place + Vector2d(0, rows * kName);
    if (!space.is_free(box_at(moved))) continue;
    at = moved;
    break;
  }
  space.take(box_at(at));
  drawing.text(at, room.name, "class=\"on-map room-name middle\"");
  drawing.text(at + Vector2d(0, 26), area, "class=\"on-map middle\"");
}

// What the drawing's signs mean, side by side in as many rows as the width asks for.
class Legend {
 public:
  struct Entry {
    std::string look;  // of its swatch; of a circle where it is a door
    std::string words;
    bool is_door = false;
    Vector2d place = Vector2d::Zero();  // of the swatch's middle
  };

  Legend(const FloorPlanView& view, double width, double ruler_px) {
    for (std::size_t i = 0; i < view.rooms.size(); ++i) {
      if (view.rooms[i].floor_m2 <= 0) continue;
      entries_.push_back({cell_look(static_cast<std::int16_t>(i), true), view.rooms[i].name});
    }
    if (!entries_.empty()) {
      entries_.push_back({cell_look(0, false), "darker: what stands there"});
    }
    for (const bool is_walked : {true, false}) {
      if (std::ranges::count(view.doors, is_walked, &FloorPlanView::Door::is_walked) == 0) continue;
      entries_.push_back(
          {door_look(is_walked), is_walked ? "door" : "door, nobody walked through", true});
    }
    Vector2d place(kMargin + ruler_px + 80, kLegendRow / 2);
    for (Entry& entry : entries_) {
      const double entry_width = kSwatch + 44 + LabelSpace::width_of(entry.words, kLetter);
      if (place.x() + entry_width > width && place.x() > kMargin) {
        place = {kMargin, place.y() + kLegendRow};
      }
      entry.place = place + Vector2d(kSwatch / 2, 0);
      place.x() += entry_width;
    }
    height_ = place.y() + kLegendRow / 2;
  }

  [[nodiscard]] double height() const { return height_; }
  void draw(SvgDrawing& drawing, double top) const {
    for (const Entry& entry : entries_) {
      const Vector2d middle = entry.place + Vector2d(0, top);
      if (entry.is_door) {
        drawing.circle(middle, kDoorRadius, entry.look);
      } else {
        const Vector2d half(kSwatch / 2, kSwatch / 2);
        drawing.rectangle(middle - half, 2 * half, entry.look);
      }
      drawing.text(middle + Vector2d(kSwatch / 2 + 8, 7), entry.words, "class=\"on-map\"");
    }
  }

 private:
  std::vector<Entry> entries_;
  double height_ = 0;
};

}  // namespace

SvgDrawing draw_floor_plan(const FloorPlanView& view) {
  const CellBounds bounds = bounds_of(view);
  const Vector2d cells(std::max(1, bounds.right - bounds.left + 1),
                       std::max(1, bounds.high - bounds.low + 1));
  const double cell_px = kLongerSide / cells.maxCoeff();
  const Vector2d plan = cell_px * cells + Vector2d(2 * kMargin, 2 * kMargin);
  const double metre_px = cell_px / view.cell_m;
  const Legend legend(view, plan.x(), metre_px);
  const auto to_px = [&](const Vector2d& place) {
    return Vector2d(kMargin + cell_px * (place.x() - bounds.left),
                    kMargin + cell_px * (bounds.high + 1 - place.y()));
  };

  const Vector2d size = plan + Vector2d(0, legend.height());
  SvgDrawing drawing(
      size.x(), size.y(),
      fmt::format("Plan of {} rooms with {} doors", view.rooms.size(), view.doors.size()));
  drawing.rectangle({0, 0}, size, "class=\"map-paper\"");
  draw_cells(drawing, view, bounds, cell_px, to_px);
  LabelSpace space(plan);
  for (const FloorPlanView::Door& door : view.doors) {
    const Vector2d place = to_px(door.place);
    drawing.circle(place, kDoorRadius, door_look(door.is_walked));
    space.take({place.array() - kDoorRadius, place.array() + kDoorRadius});
  }
  for (const FloorPlanView::Room& room : view.rooms) {
    if (room.floor_m2 > 0) draw_name(drawing, room, to_px(room.place), space);
  }
  const Vector2d ruler(kMargin, plan.y() + kLegendRow / 2);
  drawing.line(ruler, ruler + Vector2d(metre_px, 0), "class=\"ruler\"");
  drawing.text(ruler + Vector2d(metre_px + 12, 7), "1 m", "class=\"on-map\"");
  legend.draw(drawing, plan.y());
  return drawing;
}

}  // namespace roomwise::evaluation
