#include <Eigen/Geometry>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/base/file.h"
#include "roomwise/evaluation/drawing/floor_plan_drawing.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/rooms/room_outline.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct LayoutOptions {
  fs::path home;
  fs::path plan;  // empty: no picture
};

// The plan is drawn turned as the map in the report: cells of the turned picture take what the grid
// has at their middles.
evaluation::FloorPlanView view_of(const pipeline::HomeLayout& home) {
  const fusion::FloorGrid& grid = home.grid;
  const Eigen::Rotation2Dd turned_from_plan(
      -pipeline::drawing_direction_rad(grid, home.frame.storeys));
  Eigen::AlignedBox2d extent;
  const Eigen::Vector2d size = grid.cell_m() * Eigen::Vector2d(grid.columns(), grid.rows());
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(size.x(), 0), Eigen::Vector2d(0, size.y()), size}) {
    extent.extend(turned_from_plan * (grid.origin_m() + corner));
  }
  const auto in_cells = [&](const Eigen::Vector2d& point_plan) {
    return Eigen::Vector2d((turned_from_plan * point_plan - extent.min()) / grid.cell_m());
  };
  const Eigen::Array2i cells = (extent.sizes() / grid.cell_m()).array().ceil().max(1).cast<int>();
  evaluation::FloorPlanView view;
  view.cell_m = grid.cell_m();
  view.room_of_cell = image::Image<std::int16_t>(cells.x(), cells.y(), -1);
  view.is_floor = image::Image<std::uint8_t>(cells.x(), cells.y(), 0);
  for (int row = 0; row < cells.y(); ++row) {
    for (int column = 0; column < cells.x(); ++column) {
      const Eigen::Vector2d middle =
          extent.min() + grid.cell_m() * Eigen::Vector2d(column + 0.5, row + 0.5);
      const Eigen::Array2i at =
          ((turned_from_plan.inverse() * middle - grid.origin_m()) / grid.cell_m())
              .array()
              .floor()
              .cast<int>();
      if ((at < 0).any() || at.x() >= grid.columns() || at.y() >= grid.rows()) continue;
      view.is_floor.at(column, row) = grid.at(at.x(), at.y()) == fusion::FloorCell::kFree ? 1 : 0;
      if (const auto room = home.layout.room_of_cell(at.x(), at.y())) {
        view.room_of_cell.at(column, row) = static_cast<std::int16_t>(*room);
      }
    }
  }
  for (const rooms::RoomExtent& room : home.layout.rooms()) {
    view.rooms.push_back({room.name, room.floor_m2, in_cells(room.middle_plan)});
  }
  for (const rooms::Doorway& doorway : home.layout.doorways()) {
    if (!doorway.is_door()) continue;
    view.doors.push_back({in_cells(doorway.middle_plan), doorway.is_walked});
  }
  return view;
}

// What leads from one room to the other, and how wide it is.
std::string way_in_words(const rooms::Doorway& doorway) {
  std::string words = doorway.is_door() ? "a door" : "open to each other";
  words += doorway.width_m == 0 ? ", how wide was not seen"
           : doorway.is_framed  ? fmt::format(", {:.1f} m wide", doorway.width_m)
                                : fmt::format(", at least {:.1f} m wide", doorway.width_m);
  return doorway.is_walked ? words : words + ", nobody walked through";
}

std::string rails_in_words(const fusion::Staircase& stairs) {
  if (stairs.has_left_rail && stairs.has_right_rail) return ", rails on both sides";
  if (stairs.has_left_rail) return ", rail on the left";
  return stairs.has_right_rail ? ", rail on the right" : "";
}

// Of a home of several storeys; else nothing is added.
void add_storeys(const pipeline::HomeLayout& home, Answer& answer) {
  const fusion::Storeys& storeys = home.frame.storeys;
  if (!storeys.are_several()) return;
  Json all = Json::array(), flights = Json::array();
  for (std::size_t i = 0; i < storeys.count(); ++i) {
    const fusion::Storey& storey = storeys.all()[i];
    std::string rooms;
    for (const rooms::RoomExtent& room : home.layout.rooms()) {
      if (room.floor_m2 == 0 || storeys.at_plan(room.middle_plan) != i) continue;
      rooms += (rooms.empty() ? "" : ", ") + room.name;
    }
    answer.text += fmt::format("storey {}, {:.2f} m up: {}\n", i + 1, storey.floor_m, rooms);
    all.push_back(
        {{"floor_m", storey.floor_m},
         {"plan_from_level_m", {storey.plan_from_gravity.x(), storey.plan_from_gravity.y()}}});
  }
  for (const fusion::Staircase& stairs : storeys.stairs()) {
    const auto below = home.layout.room_at(stairs.below_plan);
    const auto above = home.layout.room_at(stairs.above_plan);
    answer.text += fmt::format(
        "stairs from {} up to {}: {}{}{}\n",
        below.value_or("storey " + std::to_string(stairs.lower + 1)),
        above.value_or("storey " + std::to_string(stairs.lower + 2)),
        stairs.steps > 0 ? fmt::format("{} steps", stairs.steps) : "steps were not counted",
        stairs.width_m > 0 ? fmt::format(", {:.1f} m wide", stairs.width_m) : "",
        rails_in_words(stairs));
    flights.push_back(
        {{"rooms", {below ? Json(*below) : Json(nullptr), above ? Json(*above) : Json(nullptr)}},
         {"storeys", {stairs.lower, stairs.lower + 1}},
         {"foot_m", {stairs.foot_gravity.x(), stairs.foot_gravity.y()}},
         {"top_m", {stairs.top_gravity.x(), stairs.top_gravity.y()}},
         {"up_rad", stairs.up_rad},
         {"steps", stairs.steps},
         {"height_m", stairs.height_m},
         {"width_m", stairs.width_m},
         {"left_rail", stairs.has_left_rail},
         {"right_rail", stairs.has_right_rail}});
  }
  answer.json["storeys"] = std::move(all);
  answer.json["stairs"] = std::move(flights);
}

Answer answer_of(const pipeline::HomeLayout& home) {
  Answer answer;
  answer.json = {{"rooms", Json::array()}, {"doorways", Json::array()}};
  for (const rooms::RoomExtent& room : home.layout.rooms()) {
    answer.text += fmt::format("{}: {:.1f} m2 of free floor\n", room.name, room.floor_m2);
    answer.json["rooms"].push_back({{"name", room.name},
                                    {"floor_m2", room.floor_m2},
                                    {"middle_m", {room.middle_plan.x(), room.middle_plan.y()}},
                                    {"neighbors", home.layout.neighbors(room.name)}});
    if (home.frame.storeys.are_several()) {
      answer.json["rooms"].back()["storey"] = home.frame.storeys.at_plan(room.middle_plan);
    }
  }
  for (const rooms::Doorway& doorway : home.layout.doorways()) {
    if (doorway.is_stairs) continue;
    answer.text +=
        fmt::format("{} to {}: {}, at {:.1f} {:.1f} m\n", doorway.rooms[0], doorway.rooms[1],
                    way_in_words(doorway), doorway.middle_plan.x(), doorway.middle_plan.y());
    answer.json["doorways"].push_back(
        {{"rooms", doorway.rooms},
         {"middle_m", {doorway.middle_plan.x(), doorway.middle_plan.y()}},
         {"width_m", doorway.width_m},
         {"door", doorway.is_door()},
         {"walked", doorway.is_walked}});
  }
  add_storeys(home, answer);
  answer.json["level_from_world"] = level_from_world_json(home.frame.gravity_from_world);
  return answer;
}

Expected<Answer> lay_out(const LayoutOptions& options, Context& context) {
  const fs::path folder = options.plan.parent_path();
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored)) {
    return fail("{}: no such folder to draw the plan in", folder.string());
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::HomeLayout layout, pipeline::build_home_layout(home, {}, run));
  Answer answer = answer_of(layout);
  if (!options.plan.empty()) {
    ROOMWISE_RETURN_IF_ERROR(
        write_file(options.plan, evaluation::draw_floor_plan(view_of(layout)).file()));
    answer.text += fmt::format("wrote the plan to {}\n", options.plan.string());
    answer.json["plan"] = options.plan.string();
  }
  return answer;
}

}  // namespace

void add_layout_command(CLI::App& group, Context& context) {
  const auto [command, options] =
      add_command<LayoutOptions>(group, context, "layout",
                                 "Where the named rooms lie on the floor, how much free floor they "
                                 "have, and which opens to which",
                                 "roomwise rooms layout --home my.home --plan plan.svg", lay_out);
  command->add_option("--home", options.home, "Home file with a map and named rooms")->required();
  command->add_option("--plan", options.plan, "SVG file to draw the plan to");
}

}  // namespace roomwise::app
