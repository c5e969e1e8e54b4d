// The plan of a home as IndoorGML, read by a script written from the standard (tests/readers/) and,
// where they lie here, checked against the standard's own schemas.

#include "roomwise/pipeline/exports/indoor_gml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "made_up_home.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/exports/home_json.h"
#include "roomwise/pipeline/exports/scene_graph_json.h"
#include "run_program.h"

namespace roomwise {
namespace {

namespace fs = std::filesystem;

using Eigen::Vector2d;
using Eigen::Vector3d;
using fusion::FloorCell;
using nlohmann::json;
using pipeline::HomeContents;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ProgramResult;
using testing::ScratchFolder;
using ::testing::SizeIs;

constexpr double kCell_m = 0.1;
constexpr const char* kHall = "Diele <unten> & \"vorn\"";
constexpr const char* kLanding = "it's\nup ]]> \xFFthere, été";
constexpr const char* kLandingWritten = "it's up ]]> \xEF\xBF\xBDthere, été";

// Where nothing else is said the map shows nothing.
class DrawnPlan {
 public:
  DrawnPlan(int columns, int rows) : cells_(columns, rows, FloorCell::kUnknown) {}

  // From a cell on, so many; free within a wall of one cell.
  DrawnPlan& room(int column, int row, int columns, int rows) {
    for (int y = row; y < row + rows; ++y) {
      for (int x = column; x < column + columns; ++x) {
        const bool is_wall =
            x == column || y == row || x + 1 == column + columns || y + 1 == row + rows;
        cells_.at(x, y) = is_wall ? FloorCell::kOccupied : FloorCell::kFree;
      }
    }
    return *this;
  }
  DrawnPlan& gap(int column, int row) {
    cells_.at(column, row) = FloorCell::kFree;
    return *this;
  }
  [[nodiscard]] fusion::FloorGrid grid() const { return {Vector2d::Zero(), kCell_m, cells_}; }

 private:
  image::Image<FloorCell> cells_;
};

void walk(rooms::WalkedPath& path, const Vector2d& from, const Vector2d& to,
          const std::string& room) {
  for (int i = 0; i <= 20; ++i) path.push_back({from + (to - from) * i / 20, room});
}

HomeContents contents_of(const DrawnPlan& plan, const std::vector<rooms::WalkedPath>& walks,
                         std::vector<rooms::Room> named, const fusion::Storeys& storeys = {}) {
  HomeContents contents;
  contents.floor.frame.has_floor = true;
  contents.floor.frame.storeys = storeys;
  contents.floor.grid = plan.grid();
  contents.layout = rooms::RoomLayout::make(*contents.floor.grid, walks).value();
  for (const fusion::Staircase& flight : storeys.stairs()) {
    contents.layout->add_stairs(flight.below_plan, flight.above_plan);
  }
  contents.rooms = std::move(named);
  return contents;
}

// A room of 6 m by 2 m, another of 4 m by 2 m that lies 2.5 m higher and farther along x, and
// stairs of 14 steps. The plan draws the upper one 20 m along x.
fusion::Storeys two_storeys() {
  fusion::Storey upper;
  upper.floor_m = 2.5;
  upper.plan_from_gravity = {20, 0};
  upper.plan_from_x_m = 18;
  fusion::Staircase stairs;
  stairs.below_plan = {5.5, 1};
  stairs.above_plan = {30, 1};
  stairs.foot_gravity = {6, 1};
  stairs.top_gravity = {9.5, 1};
  stairs.height_m = 2.5;
  stairs.steps = 14;
  stairs.width_m = 0.9;
  stairs.has_left_rail = stairs.has_right_rail = true;
  return fusion::Storeys({fusion::Storey{}, upper}, {stairs});
}

HomeContents two_storey_home() {
  rooms::WalkedPath below, above;
  walk(below, {0.5, 1}, {5.5, 1}, kHall);
  walk(above, {30, 1}, {33.5, 1}, kLanding);
  HomeContents contents =
      contents_of(DrawnPlan(345, 25).room(0, 0, 62, 22).room(298, 0, 42, 22), {below, above},
                  {{kHall, "hallway"}, {kLanding, ""}}, two_storeys());
  pipeline::ThingContent lamp;
  lamp.instance.name = "lamp & \x01shade";
  lamp.instance.probability = 0.875;
  lamp.box_gravity = geometry::OrientedBox{{Eigen::Quaterniond::Identity(), Vector3d(11, 1, 3.5)},
                                           Vector3d(0.2, 0.3, 0.4)};
  lamp.room = kLanding;
  pipeline::ThingContent elsewhere = lamp;
  elsewhere.component = 1;
  elsewhere.box_gravity.reset();
  contents.things = {lamp, elsewhere};
  return contents;
}

class IndoorGmlTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  static json read(const std::string& file) {
    const ProgramResult result = testing::run_program(
        "/usr/bin/python3",
        {std::string(ROOMWISE_SOURCES) + "/tests/readers/read_indoorgml.py", file});
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return json::parse(result.output, nullptr, false);
  }
  [[nodiscard]] json read(const HomeContents& contents) const {
    const auto plan = pipeline::indoor_gml(contents);
    EXPECT_OK(plan);
    EXPECT_OK(write_file(path("plan.gml"), plan->gml));
    return read(path("plan.gml"));
  }

  ScratchFolder folder_;
};

TEST_F(IndoorGmlTest, TwoRoomsOnTwoStoreysAreJoinedByStairs) {
  const json plan = read(two_storey_home());
  const json& spaces = plan.at("spaces");
  ASSERT_THAT(spaces, SizeIs(2));
  EXPECT_EQ(spaces[0].at("name"), kHall);
  EXPECT_EQ(spaces[0].at("type"), "hallway");
  EXPECT_EQ(spaces[0].at("storey"), 0);
  EXPECT_EQ(spaces[0].at("corners"), 4);
  EXPECT_EQ(spaces[0].at("low"), (json{0, 0}));
  EXPECT_EQ(spaces[0].at("high"), (json{6.2, 2.2}));
  EXPECT_EQ(spaces[1].at("name"), kLandingWritten);
  EXPECT_EQ(spaces[1].at("type"), "unknown");
  EXPECT_EQ(spaces[1].at("storey"), 1);
  EXPECT_EQ(spaces[1].at("floor_m"), 2.5);
  EXPECT_EQ(spaces[1].at("low"), (json{9.8, 0})) << "where it lies, not where the plan draws it";
  EXPECT_EQ(spaces[1].at("high"), (json{14, 2.2}));
  EXPECT_THAT(plan.at("storeys"), ElementsAre("storey 0", "storey 1"));

  ASSERT_THAT(plan.at("transitions"), SizeIs(1));
  const json& stairs = plan.at("transitions")[0];
  EXPECT_EQ(stairs.at("name"), "stairs");
  EXPECT_THAT(stairs.at("rooms"), ElementsAre(kHall, kLandingWritten));
  EXPECT_EQ(stairs.at("line")[1], (json{6, 1, 0}));
  EXPECT_EQ(stairs.at("line")[2], (json{9.5, 1, 2.5}));
  EXPECT_EQ(stairs.at("facts"), (json{{"type", "stairs"},
                                      {"storey", "0"},
                                      {"to_storey", "1"},
                                      {"steps", "14"},
                                      {"height_m", "2.50"},
                                      {"width_m", "0.90"},
                                      {"rails", "left right"}}));
}

TEST_F(IndoorGmlTest, ASceneGraphHasTheStairsBetweenTheirRooms) {
  const json graph = json::parse(pipeline::scene_graph_json(two_storey_home()));
  std::map<json, double> heights_m;
  for (const json& node : graph.at("nodes")) {
    heights_m[node.at("id")] = node.at("attributes").at("position")[2].get<double>();
  }
  std::size_t flights = 0;
  for (const json& edge : graph.at("edges")) {
    const json& facts = edge.at("info").at("metadata");
    if (!facts.contains("stairs_m")) continue;
    ++flights;
    EXPECT_EQ(facts, (json{{"stairs_m", {5.5, 1}},
                           {"top_m", {9.5, 1}},
                           {"storeys", {0, 1}},
                           {"height_m", 2.5},
                           {"steps", 14},
                           {"width_m", 0.9},
                           {"walked", facts.at("walked")}}));
    EXPECT_NEAR(std::abs(heights_m.at(edge.at("source")) - heights_m.at(edge.at("target"))), 2.5,
                1e-9)
        << "its rooms lie on two storeys";
  }
  EXPECT_EQ(flights, 1U);
}

TEST_F(IndoorGmlTest, ThingsArePointsInTheirRooms) {
  const json plan = read(two_storey_home());
  ASSERT_THAT(plan.at("things"), SizeIs(1)) << "what lies in another piece has no place";
  const json& lamp = plan.at("things")[0];
  EXPECT_EQ(lamp.at("name"), "lamp &  shade");
  EXPECT_EQ(lamp.at("place"), (json{11, 1, 3.5}));
  EXPECT_EQ(lamp.at("room"), kLandingWritten);
  EXPECT_EQ(lamp.at("facts").at("storey"), "1");
  EXPECT_EQ(lamp.at("facts").at("probability"), "0.88");
  EXPECT_EQ(lamp.at("facts").at("size_m"), "0.20 0.30 0.40");
}

TEST_F(IndoorGmlTest, ARoomWithinAnotherIsAHoleInIt) {
  rooms::WalkedPath path;
  walk(path, {0.5, 4}, {2.95, 4}, "studio");
  walk(path, {3.05, 4}, {4, 4}, "closet");
  DrawnPlan drawn(80, 80);
  drawn.room(0, 0, 80, 80).room(30, 30, 20, 20);
  for (int row = 36; row < 44; ++row) drawn.gap(30, row);
  const json plan = read(contents_of(drawn, {path}, {{"closet", ""}, {"studio", ""}}));
  const json& spaces = plan.at("spaces");
  ASSERT_THAT(spaces, SizeIs(2));
  EXPECT_EQ(spaces[0].at("holes"), 0);
  EXPECT_EQ(spaces[1].at("holes"), 1);
  const auto area_m2 = [&](std::size_t space) { return spaces[space].at("area_m2").get<double>(); };
  EXPECT_NEAR(area_m2(0) + area_m2(1), 64, 1e-3) << "all floor belongs to one of them";
  EXPECT_NEAR(area_m2(0), 4, 0.8);
  ASSERT_THAT(plan.at("transitions"), SizeIs(1));
  const json& door = plan.at("transitions")[0];
  EXPECT_EQ(door.at("name"), "door");
  EXPECT_NEAR(door.at("line")[1][0].get<double>(), 3, 0.2);
  EXPECT_NEAR(door.at("line")[1][1].get<double>(), 4, 0.2);
  EXPECT_NEAR(std::stod(door.at("facts").at("width_m").get<std::string>()), 0.8, 0.11);
  EXPECT_EQ(door.at("facts").at("walked"), "true");
}

// A hall with a door of 0.8 m to a room, into which a kitchen opens across its whole width.
TEST_F(IndoorGmlTest, WhereTwoRoomsAreOpenToEachOtherIsNoDoor) {
  rooms::WalkedPath path;
  walk(path, {1, 1.5}, {2.9, 1.5}, "hall");
  walk(path, {3.1, 1.5}, {5.5, 1.5}, "living");
  walk(path, {6.5, 1.5}, {8.5, 1.5}, "kitchen");
  DrawnPlan drawn(95, 32);
  drawn.room(0, 0, 31, 31).room(30, 0, 62, 31);
  for (int row = 11; row < 19; ++row) drawn.gap(30, row);
  const HomeContents contents =
      contents_of(drawn, {path}, {{"hall", ""}, {"kitchen", "kitchen"}, {"living", ""}});
  const json transitions = read(contents).at("transitions");
  ASSERT_THAT(transitions, SizeIs(2));
  const bool door_first = transitions[0].at("name") == "door";
  const json& door = transitions[door_first ? 0 : 1];
  const json& opening = transitions[door_first ? 1 : 0];
  EXPECT_EQ(door.at("name"), "door");
  EXPECT_EQ(door.at("facts").at("type"), "door");
  EXPECT_THAT(door.at("rooms"), ::testing::UnorderedElementsAre("hall", "living"));
  EXPECT_EQ(opening.at("name"), "opening");
  EXPECT_EQ(opening.at("facts").at("type"), "opening");
  EXPECT_THAT(opening.at("rooms"), ::testing::UnorderedElementsAre("kitchen", "living"));
  EXPECT_GT(std::stod(opening.at("facts").at("width_m").get<std::string>()), 2);
  const auto plan = pipeline::indoor_gml(contents);
  ASSERT_OK(plan);
  EXPECT_EQ(plan->doors, 1U);
  EXPECT_EQ(plan->openings, 1U);

  const json exported = json::parse(pipeline::home_json(contents));
  ASSERT_THAT(exported.at("doors"), SizeIs(1));
  EXPECT_THAT(exported.at("doors")[0].at("rooms"),
              ::testing::UnorderedElementsAre("hall", "living"));
  ASSERT_THAT(exported.at("openings"), SizeIs(1));
  EXPECT_THAT(exported.at("openings")[0].at("rooms"),
              ::testing::UnorderedElementsAre("kitchen", "living"));
  std::set<std::string> ways;
  const json graph = json::parse(pipeline::scene_graph_json(contents));
  for (const json& edge : graph.at("edges")) {
    for (const auto& [fact, value] : edge.at("info").at("metadata").items()) ways.insert(fact);
  }
  EXPECT_THAT(ways, ElementsAre("door_m", "opening_m", "walked", "width_m"));
}

TEST_F(IndoorGmlTest, WhatOfARoomLiesApartIsAFurtherSpaceOfItsName) {
  rooms::WalkedPath one, other;
  walk(one, {0.5, 1}, {5.5, 1}, "cellar");
  walk(other, {8, 1}, {8.5, 1}, "cellar");
  const json plan = read(contents_of(DrawnPlan(110, 25).room(70, 0, 20, 22).room(0, 0, 62, 22),
                                     {one, other}, {{"cellar", ""}, {"attic", ""}}));
  const json& spaces = plan.at("spaces");
  ASSERT_THAT(spaces, SizeIs(2));
  EXPECT_EQ(spaces[0].at("id"), "room-1");
  EXPECT_EQ(spaces[1].at("part_of"), "room-1");
  EXPECT_EQ(spaces[1].at("name"), "cellar");
  EXPECT_TRUE(spaces[1].at("state").is_null());
  EXPECT_THAT(plan.at("states"), SizeIs(1));
  EXPECT_THAT(plan.at("transitions"), IsEmpty());
}

TEST_F(IndoorGmlTest, WhatHasNoPlaceIsCounted) {
  HomeContents contents = two_storey_home();
  contents.rooms.push_back({"attic", ""});
  const auto plan = pipeline::indoor_gml(contents);
  ASSERT_OK(plan);
  EXPECT_EQ(plan->rooms, 2U);
  EXPECT_EQ(plan->stairs, 1U);
  EXPECT_EQ(plan->things, 1U);
  EXPECT_EQ(plan->rooms_without_place, 1U);
  EXPECT_EQ(plan->stairs_without_rooms, 0U);
  fusion::Staircase nowhere = two_storeys().stairs()[0];
  nowhere.above_plan = {24, 1};
  contents.floor.frame.storeys = fusion::Storeys(two_storeys().all(), {nowhere});
  EXPECT_EQ(pipeline::indoor_gml(contents).value().stairs_without_rooms, 1U);
}

TEST_F(IndoorGmlTest, AHomeWithoutAPlanSaysWhatItLacks) {
  HomeContents contents = two_storey_home();
  contents.layout.reset();
  EXPECT_ERROR(pipeline::indoor_gml(contents), "no named place of the walk lies on free floor");
  contents.floor.grid.reset();
  EXPECT_ERROR(pipeline::indoor_gml(contents), "the map shows no floor");
  contents.rooms.clear();
  EXPECT_ERROR(pipeline::indoor_gml(contents), "name them with roomwise rooms name");
}

TEST_F(IndoorGmlTest, TheCommandTellsThePlanOfAMappedHome) {
  ASSERT_OK(testing::make_made_up_home(path("my.home")));
  const json told =
      testing::result_of({"export", "indoorgml", "--home", path("my.home"), "-o", path("my.gml")});
  EXPECT_EQ(told.at("rooms"), 2);
  EXPECT_EQ(told.at("doors"), 1);
  EXPECT_EQ(told.at("stairs"), 0);
  EXPECT_EQ(told.at("things"), 2);
  EXPECT_EQ(told.at("things_elsewhere"), 1);
  const json plan = read(path("my.gml"));
  ASSERT_THAT(plan.at("states"), SizeIs(2));
  EXPECT_EQ(plan.at("states")[0].at("name"), testing::kMadeUpLiving);
  EXPECT_THAT(plan.at("transitions")[0].at("rooms"),
              ElementsAre(testing::kMadeUpLiving, testing::kMadeUpKitchen));
  ASSERT_THAT(plan.at("things"), SizeIs(2));
  EXPECT_EQ(plan.at("things")[0].at("name"), "canapé \"3\"");
  EXPECT_EQ(plan.at("things")[0].at("room"), testing::kMadeUpLiving);
  EXPECT_EQ(plan.at("things")[1].at("room"), testing::kMadeUpKitchen);
  EXPECT_NEAR(plan.at("things")[0].at("place")[2].get<double>(), 0.35, 0.05);
}

TEST_F(IndoorGmlTest, TheCommandSaysWhyAHomeHasNoPlan) {
  ASSERT_OK(testing::make_made_up_home(path("bare.home"), {.has_rooms = false}));
  const ProgramResult said = testing::run_roomwise(
      {"export", "indoorgml", "--home", path("bare.home"), "-o", path("bare.gml")});
  EXPECT_EQ(said.exit_code, 1);
  EXPECT_THAT(said.errors, HasSubstr("bare.home: no rooms are named"));
  EXPECT_FALSE(fs::exists(path("bare.gml")));
}

// ROOMWISE_SCHEMAS names a folder with schemas.opengis.net/{indoorgml/1.0, gml/3.2.1,
// iso/19139/20070417} and www.w3.org/{1999/xlink.xsd, 2001/xml.xsd}, as these hosts publish them.
class IndoorGmlSchemaTest : public IndoorGmlTest {
 protected:
  void SetUp() override {
    const char* const schemas = std::getenv("ROOMWISE_SCHEMAS");
    if (schemas == nullptr) GTEST_SKIP() << "ROOMWISE_SCHEMAS names no folder with OGC's schemas";
    if (!fs::exists("/usr/bin/xmllint")) GTEST_SKIP() << "there is no xmllint (libxml2-utils)";
    const std::string prefix = "file://" + fs::absolute(schemas).string() + "/";
    ASSERT_OK(write_file(path("catalog.xml"),
                         "<catalog xmlns=\"urn:oasis:names:tc:entity:xmlns:xml:catalog\">"
                         "<rewriteSystem systemIdStartString=\"http://\" rewritePrefix=\"" +
                             prefix +
                             "\"/>"
                             "<rewriteURI uriStartString=\"http://\" rewritePrefix=\"" +
                             prefix + "\"/></catalog>"));
  }
  [[nodiscard]] ProgramResult validate(const std::string& file) const {
    return testing::run_program(
        "/usr/bin/env",
        {"XML_CATALOG_FILES=" + path("catalog.xml"), "/usr/bin/xmllint", "--nonet", "--noout",
         "--schema", "http://schemas.opengis.net/indoorgml/1.0/indoorgmlnavi.xsd", file});
  }
};

TEST_F(IndoorGmlSchemaTest, PlansAreValid) {
  ASSERT_OK(write_file(path("two.gml"), pipeline::indoor_gml(two_storey_home()).value().gml));
  ASSERT_OK(testing::make_made_up_home(path("my.home")));
  testing::result_of({"export", "indoorgml", "--home", path("my.home"), "-o", path("my.gml")});
  for (const char* file : {"two.gml", "my.gml"}) {
    const ProgramResult said = validate(path(file));
    EXPECT_EQ(said.exit_code, 0) << said.errors;
    EXPECT_THAT(said.errors, HasSubstr("validates"));
  }
}

TEST_F(IndoorGmlSchemaTest, APlanWithAWordForALengthIsNot) {
  std::string gml = pipeline::indoor_gml(two_storey_home()).value().gml;
  const std::string name = "<weight>";
  gml.replace(gml.find(name), name.size(), "<weight>far");
  ASSERT_OK(write_file(path("broken.gml"), gml));
  EXPECT_THAT(validate(path("broken.gml")).errors, HasSubstr("weight"));
}

}  // namespace
}  // namespace roomwise
