#include "roomwise/evaluation/floor_plan_drawing.h"

#include <fmt/format.h>

#include <algorithm>

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;

constexpr double kLongerSide = 1000, kMargin = 30, kFoot = 60;  // px

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
                          fmt::format("class=\"dot-{}\" fill-opacity=\"{}\"", room % kColors,
                                      is_floor ? 0.3 : 0.6));
      }
      begin = end;
    }
  }
}

}  // namespace

SvgDrawing draw_floor_plan(const FloorPlanView& view) {
  const CellBounds bounds = bounds_of(view);
  const Vector2d cells(std::max(1, bounds.right - bounds.left + 1),
                       std::max(1, bounds.high - bounds.low + 1));
  const double cell_px = kLongerSide / cells.maxCoeff();
  const Vector2d size = cell_px * cells + Vector2d(2 * kMargin, 2 * kMargin + kFoot);
  const auto to_px = [&](const Vector2d& place) {
    return Vector2d(kMargin + cell_px * (place.x() - bounds.left),
                    kMargin + cell_px * (bounds.high + 1 - place.y()));
  };

  SvgDrawing drawing(
      size.x(), size.y(),
      fmt::format("Plan of {} rooms with {} doorways", view.rooms.size(), view.doorways.size()));
  drawing.rectangle({0, 0}, size, "class=\"map-paper\"");
  draw_cells(drawing, view, bounds, cell_px, to_px);
  for (const FloorPlanView::Doorway& doorway : view.doorways) {
    drawing.circle(
        to_px(doorway.place), 9,
        doorway.is_walked ? "class=\"object\" style=\"fill:#111111\"" : "class=\"object\"");
  }
  for (const FloorPlanView::Room& room : view.rooms) {
    if (room.floor_m2 <= 0) continue;
    const Vector2d place = to_px(room.place);
    drawing.text(place, room.name, "class=\"on-map room-name middle\"");
    drawing.text(place + Vector2d(0, 26), fmt::format("{:.0f} m²", room.floor_m2),
                 "class=\"on-map middle\"");
  }
  const Vector2d ruler(kMargin, size.y() - kFoot / 2);
  drawing.line(ruler, ruler + Vector2d(cell_px / view.cell_m, 0), "class=\"ruler\"");
  drawing.text(ruler + Vector2d(cell_px / view.cell_m + 12, 7), "1 m", "class=\"on-map\"");
  return drawing;
}

}  // namespace roomwise::evaluation
