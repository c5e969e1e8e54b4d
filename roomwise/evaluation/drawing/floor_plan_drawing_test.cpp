#include "roomwise/evaluation/drawing/floor_plan_drawing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "roomwise/evaluation/testing/test_markup.h"

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Two rooms of two cells beside each other, above an empty row; a chair in the right one.
FloorPlanView two_rooms() {
  FloorPlanView view;
  view.cell_m = 1;
  view.room_of_cell = image::Image<std::int16_t>(4, 2, -1);
  view.is_floor = image::Image<std::uint8_t>(4, 2, 0);
  for (int column = 0; column < 4; ++column) {
    view.room_of_cell.at(column, 1) = column < 2 ? 0 : 1;
    view.is_floor.at(column, 1) = column < 3 ? 1 : 0;
  }
  view.rooms = {{"bed & bath", 2, {1, 1.5}}, {"hall", 1, {2.5, 1.5}}, {"porch", 0, {9, 9}}};
  view.doors = {{{2, 1.5}, true}};
  return view;
}

TEST(FloorPlanDrawingTest, RoomsFillThePictureAndCarryTheirNames) {
  const std::string svg = draw_floor_plan(two_rooms()).file();
  EXPECT_THAT(svg, HasSubstr("Plan of 3 rooms with 1 doors"));
  EXPECT_THAT(svg, HasSubstr("bed &amp; bath"));
  EXPECT_THAT(svg, HasSubstr("2 m²"));
  EXPECT_THAT(svg, Not(HasSubstr("porch"))) << "it has no floor to write on";
  // 1000 px for four cells: the empty row is cut away.
  EXPECT_THAT(svg, HasSubstr("width=\"500\" height=\"250\" class=\"dot-0\" fill-opacity=\"0.3\" "));
  EXPECT_THAT(svg, HasSubstr("width=\"250\" height=\"250\" class=\"dot-1\" fill-opacity=\"0.6\" "));
}

TEST(FloorPlanDrawingTest, ALegendTellsRoomsAndDoors) {
  FloorPlanView view = two_rooms();
  const std::string svg = draw_floor_plan(view).file();
  EXPECT_EQ(count_of(svg, ">hall<"), 2) << "on the plan and in the legend";
  EXPECT_EQ(count_of(svg, ">door<"), 1);
  EXPECT_THAT(svg, Not(HasSubstr("nobody walked through")));
  view.doors.push_back({{3, 1.5}, false});
  EXPECT_THAT(draw_floor_plan(view).file(), HasSubstr(">door, nobody walked through<"));
}

TEST(FloorPlanDrawingTest, NoNameCoversAnotherOrADoor) {
  FloorPlanView view = two_rooms();
  view.rooms[0].place = view.rooms[1].place = view.doors[0].place = {2, 1.5};
  const std::string svg = draw_floor_plan(view).file();
  const auto y_of = [&](const std::string& name) {
    const std::size_t end = svg.find(" class=\"on-map room-name middle\">" + name);
    const std::size_t from = svg.rfind("y=\"", end) + 3;
    return std::stod(svg.substr(from, svg.find('"', from) - from));
  };
  const double door_y = 155, bed = y_of("bed"), hall = y_of("hall");
  EXPECT_GT(std::abs(bed - hall), 40);
  EXPECT_GT(std::abs(bed - door_y), 9);
  EXPECT_GT(std::abs(hall - door_y), 9);
}

TEST(FloorPlanDrawingTest, WithoutRoomsThereIsAnEmptyPicture) {
  FloorPlanView view = two_rooms();
  view.rooms.clear();
  view.doors.clear();
  view.room_of_cell = image::Image<std::int16_t>(4, 2, -1);
  EXPECT_THAT(draw_floor_plan(view).file(), Not(HasSubstr("dot-0\" fill")));
}

}  // namespace
}  // namespace roomwise::evaluation
