#include "roomwise/pipeline/exports/indoor_gml.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "roomwise/pipeline/exports/xml_writer.h"
#include "roomwise/pipeline/rooms/room_outline.h"

namespace roomwise::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::CellPolygon;

// A millimetre is finer than any map.
std::string number(double value) {
  const std::string text = fmt::format("{:.3f}", value);
  return text == "-0.000" ? "0.000" : text;
}

std::string place_text(const Vector3d& place) {
  return fmt::format("{} {} {}", number(place.x()), number(place.y()), number(place.z()));
}

std::string places_text(const std::vector<Vector3d>& places) {
  std::string text;
  for (const Vector3d& place : places) {
    if (!text.empty()) text += ' ';
    text += place_text(place);
  }
  return text;
}

// One fact of a gml:description.
std::string fact(std::string_view key, std::string_view value) {
  return fmt::format("{}=\"{}\":", key, value);
}
std::string fact(std::string_view key, std::size_t value) {
  return fact(key, fmt::format("{}", value));
}
// Only what is known.
std::string length_fact(std::string_view key, double length_m) {
  return length_m > 0 ? fact(key, fmt::format("{:.2f}", length_m)) : "";
}

// The point in cells, as the ring is.
bool is_inside(const geometry::CellRing& ring, const Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2d a = ring[i].cast<double>(), b = ring[(i + 1) % ring.size()].cast<double>();
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double crossing = a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y());
    if (point.x() < crossing) inside = !inside;
  }
  return inside;
}

bool is_inside(const CellPolygon& polygon, const Vector2d& point) {
  return is_inside(polygon.outer, point) &&
         std::ranges::none_of(polygon.holes,
                              [&](const auto& hole) { return is_inside(hole, point); });
}

struct RoomInPlan {
  std::string name, type;
  std::size_t storey = 0;
  Vector3d middle_gravity = Vector3d::Zero();
  std::vector<CellPolygon> parts;  // the first is the one in which the middle lies
};

struct Link {
  std::string id, name, description;
  std::size_t from = 0, to = 0;  // rooms
  std::vector<Vector3d> path;

  [[nodiscard]] double length_m() const {
    double length = 0;
    for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
    return length;
  }
};

struct PlacedThing {
  const ThingContent* thing = nullptr;
  Vector3d middle_gravity = Vector3d::Zero();
  std::optional<std::size_t> room;
};

std::string room_id(std::size_t room) {
  return fmt::format("room-{}", room + 1);
}
std::string state_id(std::size_t room) {
  return fmt::format("state-{}", room + 1);
}
std::string thing_id(std::size_t thing) {
  return fmt::format("thing-{}", thing + 1);
}
std::string link_to(const std::string& id) {
  return "#" + id;
}

// What of a home the plan shows.
class PlanContents {
 public:
  explicit PlanContents(const HomeContents& contents) : contents_(contents) {
    find_rooms();
    find_doors();
    find_stairs();
    find_things();
  }

  std::vector<RoomInPlan> rooms;
  std::vector<Link> doors, stairs;  // the first with the openings
  std::size_t doors_only = 0, openings = 0;
  std::vector<PlacedThing> things;
  std::size_t stairs_without_rooms = 0;

  // Corners of a ring on the floor of a storey, the first one also last.
  [[nodiscard]] std::vector<Vector3d> corners(const geometry::CellRing& ring) const {
    const fusion::FloorGrid& grid = *contents_.floor.grid;
    std::vector<Vector3d> places;
    for (std::size_t i = 0; i <= ring.size(); ++i) {
      places.push_back(contents_.place_gravity(
          grid.origin_m() + grid.cell_m() * ring[i % ring.size()].cast<double>()));
    }
    return places;
  }
  // Around all that is written.
  [[nodiscard]] Eigen::AlignedBox3d extent() const {
    Eigen::AlignedBox3d box;
    for (const RoomInPlan& room : rooms) {
      box.extend(room.middle_gravity);
      for (const CellPolygon& part : room.parts) {
        for (const Vector3d& corner : corners(part.outer)) box.extend(corner);
      }
    }
    for (const std::vector<Link>* links : {&doors, &stairs}) {
      for (const Link& link : *links) {
        for (const Vector3d& place : link.path) box.extend(place);
      }
    }
    for (const PlacedThing& thing : things) box.extend(thing.middle_gravity);
    return box;
  }

 private:
  void find_rooms() {
    const rooms::RoomLayout& layout = *contents_.layout;
    const fusion::FloorGrid& grid = *contents_.floor.grid;
    for (std::size_t i = 0; i < layout.rooms().size(); ++i) {
      const rooms::RoomExtent& extent = layout.rooms()[i];
      if (extent.floor_m2 == 0) continue;
      RoomInPlan room;
      room.name = extent.name;
      room.storey = contents_.storeys().at_plan(extent.middle_plan);
      room.middle_gravity = contents_.place_gravity(extent.middle_plan);
      room.parts = geometry::cell_outlines(room_cells(grid, layout, i));
      const Vector2d middle = (extent.middle_plan - grid.origin_m()) / grid.cell_m();
      std::ranges::stable_partition(
          room.parts, [&](const CellPolygon& part) { return is_inside(part, middle); });
      const auto named = std::ranges::find(contents_.rooms, extent.name, &rooms::Room::name);
      if (named != contents_.rooms.end()) room.type = named->type;
      by_name_[room.name] = rooms.size();
      rooms.push_back(std::move(room));
    }
  }

  void find_doors() {
    for (const rooms::Doorway& door : contents_.layout->doorways()) {
      const auto from = by_name_.find(door.rooms[0]), to = by_name_.find(door.rooms[1]);
      if (door.is_stairs || from == by_name_.end() || to == by_name_.end()) continue;
      const Vector3d middle = contents_.place_gravity(door.middle_plan);
      // Where two rooms are open to each other there is none for a plan's reader to look for.
      const std::string kind = door.is_door() ? "door" : "opening";
      std::size_t& of_kind = door.is_door() ? doors_only : openings;
      doors.push_back(
          {fmt::format("{}-{}", kind, ++of_kind),
           kind,
           fact("type", kind) + fact("storey", contents_.storeys().at_plan(door.middle_plan)) +
               length_fact("width_m", door.width_m) +
               fact("walked", door.is_walked ? "true" : "false"),
           from->second,
           to->second,
           {rooms[from->second].middle_gravity, middle, rooms[to->second].middle_gravity}});
    }
  }

  [[nodiscard]] std::optional<std::size_t> room_at(const Vector2d& point_plan) const {
    const auto name = contents_.layout->room_at(point_plan);
    const auto room = name ? by_name_.find(*name) : by_name_.end();
    return room == by_name_.end() ? std::nullopt : std::optional(room->second);
  }

  void find_stairs() {
    for (const fusion::Staircase& flight : contents_.storeys().stairs()) {
      const auto below = room_at(flight.below_plan), above = room_at(flight.above_plan);
      if (!below || !above || *below == *above) {
        ++stairs_without_rooms;
        continue;
      }
      const double low_m = contents_.storeys().floor_m(flight.lower);
      const double high_m = contents_.storeys().floor_m(flight.lower + 1);
      const std::string rails =
          fmt::format("{}{}{}", flight.has_left_rail ? "left" : "",
                      flight.has_left_rail && flight.has_right_rail ? " " : "",
                      flight.has_right_rail ? "right" : "");
      stairs.push_back(
          {fmt::format("stairs-{}", stairs.size() + 1),
           "stairs",
           fact("type", "stairs") + fact("storey", flight.lower) +
               fact("to_storey", flight.lower + 1) +
               (flight.steps > 0 ? fact("steps", static_cast<std::size_t>(flight.steps)) : "") +
               length_fact("height_m", flight.height_m) + length_fact("width_m", flight.width_m) +
               (rails.empty() ? "" : fact("rails", rails)),
           *below,
           *above,
           {rooms[*below].middle_gravity,
            Vector3d(flight.foot_gravity.x(), flight.foot_gravity.y(), low_m),
            Vector3d(flight.top_gravity.x(), flight.top_gravity.y(), high_m),
            rooms[*above].middle_gravity}});
    }
  }

  void find_things() {
    for (const ThingContent& thing : contents_.things) {
      if (!thing.box_gravity) continue;
      PlacedThing& placed =
          things.emplace_back(PlacedThing{&thing, thing.box_gravity->center(), {}});
      if (!thing.room) continue;
      const auto room = by_name_.find(*thing.room);
      if (room != by_name_.end()) placed.room = room->second;
    }
  }

  const HomeContents& contents_;
  std::map<std::string, std::size_t> by_name_;
};

class IndoorGmlWriter {
 public:
  IndoorGmlWriter(const HomeContents& contents, const PlanContents& plan)
      : contents_(contents), plan_(plan) {}

  std::string write() && {
    xml_.open("IndoorFeatures", {{"xmlns", "http://www.opengis.net/indoorgml/1.0/core"},
                                 {"xmlns:navi", "http://www.opengis.net/indoorgml/1.0/navigation"},
                                 {"xmlns:gml", "http://www.opengis.net/gml/3.2"},
                                 {"xmlns:xlink", "http://www.w3.org/1999/xlink"},
                                 {"xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"},
                                 {"xsi:schemaLocation",
                                  "http://www.opengis.net/indoorgml/1.0/core "
                                  "http://schemas.opengis.net/indoorgml/1.0/indoorgmlcore.xsd "
                                  "http://www.opengis.net/indoorgml/1.0/navigation "
                                  "http://schemas.opengis.net/indoorgml/1.0/indoorgmlnavi.xsd"},
                                 {"gml:id", "home"}});
    write_frame();
    write_extent();
    xml_.open("primalSpaceFeatures");
    xml_.open("PrimalSpaceFeatures", {{"gml:id", "spaces"}});
    for (std::size_t room = 0; room < plan_.rooms.size(); ++room) write_spaces(room);
    close(2);
    xml_.open("multiLayeredGraph");
    xml_.open("MultiLayeredGraph", {{"gml:id", "graph"}});
    xml_.open("spaceLayers", {{"gml:id", "layers"}});
    write_rooms_layer();
    if (!plan_.things.empty()) write_things_layer();
    xml_.close();
    write_what_is_where();
    close(3);
    return std::move(xml_).document();
  }

 private:
  void close(int count) {
    for (int i = 0; i < count; ++i) xml_.close();
  }

  // The home's own: where on earth it stands nobody is told.
  void write_frame() {
    xml_.open("gml:metaDataProperty");
    xml_.open("gml:GenericMetaData");
    xml_.open("gml:EngineeringCRS", {{"gml:id", "frame"}});
    identifier("frame");
    xml_.leaf("gml:scope", "places in this home");
    xml_.open("gml:cartesianCS");
    xml_.open("gml:CartesianCS", {{"gml:id", "axes"}});
    identifier("axes");
    axis("x", "where the first camera looked, level");
    axis("y", "to its left");
    axis("z", "up");
    close(2);
    xml_.open("gml:engineeringDatum");
    xml_.open("gml:EngineeringDatum", {{"gml:id", "datum"}});
    identifier("datum");
    xml_.leaf("gml:scope", "places in this home");
    xml_.leaf("gml:anchorDefinition",
              "(0, 0) lies under the first camera of the first walk; z = 0 is the floor, with "
              "several storeys that of one of them");
    close(5);
  }
  void identifier(const std::string& name) {
    xml_.leaf("gml:identifier", name, {{"codeSpace", "roomwise"}});
  }
  void axis(const std::string& name, const std::string& direction) {
    xml_.open("gml:axis");
    xml_.open("gml:CoordinateSystemAxis", {{"gml:id", "axis-" + name}, {"uom", "m"}});
    identifier("axis-" + name);
    xml_.leaf("gml:axisAbbrev", name);
    xml_.leaf("gml:axisDirection", direction, {{"codeSpace", "roomwise"}});
    close(2);
  }

  void write_extent() {
    const Eigen::AlignedBox3d extent = plan_.extent();
    xml_.open("gml:boundedBy");
    xml_.open("gml:Envelope", {{"srsName", link_to("frame")}, {"srsDimension", "3"}});
    xml_.leaf("gml:lowerCorner", place_text(extent.min()));
    xml_.leaf("gml:upperCorner", place_text(extent.max()));
    close(2);
  }

  // What geometries say of their places.
  static XmlWriter::Attributes geometry(const std::string& id) {
    return {{"gml:id", id}, {"srsName", link_to("frame")}, {"srsDimension", "3"}};
  }

  void write_ring(std::string_view side, const geometry::CellRing& ring) {
    xml_.open(side);
    xml_.open("gml:LinearRing");
    xml_.leaf("gml:posList", places_text(plan_.corners(ring)));
    close(2);
  }

  void write_spaces(std::size_t index) {
    const RoomInPlan& room = plan_.rooms[index];
    const std::string type = room.type.empty() ? "unknown" : room.type;
    for (std::size_t part = 0; part < room.parts.size(); ++part) {
      const std::string id =
          part == 0 ? room_id(index) : fmt::format("{}-part-{}", room_id(index), part + 1);
      xml_.open("cellSpaceMember");
      xml_.open("navi:GeneralSpace", {{"gml:id", id}});
      xml_.leaf("gml:description",
                fact("storey", room.storey) + (part == 0 ? "" : fact("part_of", room_id(index))));
      xml_.leaf("gml:name", room.name);
      xml_.open("cellSpaceGeometry");
      xml_.open("Geometry2D");
      xml_.open("gml:Polygon", geometry(id + "-floor"));
      write_ring("gml:exterior", room.parts[part].outer);
      for (const geometry::CellRing& hole : room.parts[part].holes) {
        write_ring("gml:interior", hole);
      }
      close(3);
      if (part == 0) xml_.empty("duality", {{"xlink:href", link_to(state_id(index))}});
      xml_.leaf("navi:class", "room");
      xml_.leaf("navi:function", type);
      xml_.leaf("navi:usage", type);
      close(2);
    }
  }

  void write_point(const std::string& id, const Vector3d& place) {
    xml_.open("geometry");
    xml_.open("gml:Point", geometry(id));
    xml_.leaf("gml:pos", place_text(place));
    close(2);
  }

  void open_layer(const std::string& id, const std::string& kind) {
    xml_.open("spaceLayerMember");
    xml_.open("SpaceLayer", {{"gml:id", id}});
    xml_.leaf("gml:name", id);
    xml_.leaf("class", kind);
  }

  void write_rooms_layer() {
    open_layer("rooms", "TOPOGRAPHIC");
    for (std::size_t storey = 0; storey < contents_.storeys().count(); ++storey) {
      write_states(storey);
    }
    write_edges("doors", plan_.doors);
    write_edges("stairs", plan_.stairs);
    close(2);
  }

  void write_states(std::size_t storey) {
    if (std::ranges::none_of(plan_.rooms,
                             [&](const RoomInPlan& room) { return room.storey == storey; })) {
      return;
    }
    xml_.open("nodes", {{"gml:id", fmt::format("storey-{}", storey)}});
    xml_.leaf("gml:description", fact("floor_m", number(contents_.storeys().floor_m(storey))));
    xml_.leaf("gml:name", fmt::format("storey {}", storey));
    for (std::size_t room = 0; room < plan_.rooms.size(); ++room) {
      if (plan_.rooms[room].storey == storey) write_state(room);
    }
    xml_.close();
  }

  void write_state(std::size_t room) {
    xml_.open("stateMember");
    xml_.open("State", {{"gml:id", state_id(room)}});
    xml_.leaf("gml:name", plan_.rooms[room].name);
    xml_.empty("duality", {{"xlink:href", link_to(room_id(room))}});
    for (const std::vector<Link>* links : {&plan_.doors, &plan_.stairs}) {
      for (const Link& link : *links) {
        if (link.from != room && link.to != room) continue;
        xml_.empty("connects", {{"xlink:href", link_to(link.id)}});
      }
    }
    write_point(state_id(room) + "-place", plan_.rooms[room].middle_gravity);
    close(2);
  }

  void write_edges(const std::string& id, const std::vector<Link>& links) {
    if (links.empty()) return;
    xml_.open("edges", {{"gml:id", id}});
    for (const Link& link : links) {
      xml_.open("transitionMember");
      xml_.open("Transition", {{"gml:id", link.id}});
      xml_.leaf("gml:description", link.description);
      xml_.leaf("gml:name", link.name);
      xml_.leaf("weight", number(link.length_m()));
      xml_.empty("connects", {{"xlink:href", link_to(state_id(link.from))}});
      xml_.empty("connects", {{"xlink:href", link_to(state_id(link.to))}});
      xml_.open("geometry");
      xml_.open("gml:LineString", geometry(link.id + "-line"));
      xml_.leaf("gml:posList", places_text(link.path));
      close(4);
    }
    xml_.close();
  }

  void write_things_layer() {
    open_layer("things", "TAGS");
    xml_.open("nodes", {{"gml:id", "things-nodes"}});
    for (std::size_t i = 0; i < plan_.things.size(); ++i) {
      const PlacedThing& placed = plan_.things[i];
      const Vector3d& size_m = placed.thing->box_gravity->size_m;
      xml_.open("stateMember");
      xml_.open("State", {{"gml:id", thing_id(i)}});
      xml_.leaf("gml:description",
                fact("type", "thing") +
                    fact("storey", contents_.storeys().at_height(placed.middle_gravity.z())) +
                    fact("probability", fmt::format("{:.2f}", placed.thing->instance.probability)) +
                    fact("size_m",
                         fmt::format("{:.2f} {:.2f} {:.2f}", size_m.x(), size_m.y(), size_m.z())));
      xml_.leaf("gml:name", placed.thing->instance.name);
      write_point(thing_id(i) + "-place", placed.middle_gravity);
      close(2);
    }
    close(3);
  }

  // Which room a thing is in.
  void write_what_is_where() {
    if (std::ranges::none_of(plan_.things,
                             [](const PlacedThing& one) { return one.room.has_value(); })) {
      return;
    }
    xml_.open("interEdges", {{"gml:id", "what-is-where"}});
    for (std::size_t i = 0; i < plan_.things.size(); ++i) {
      if (!plan_.things[i].room) continue;
      xml_.open("interLayerConnectionMember");
      xml_.open("InterLayerConnection", {{"gml:id", thing_id(i) + "-in-room"}});
      xml_.leaf("typeOfTopoExpression", "CONTAINS");
      xml_.empty("interConnects", {{"xlink:href", link_to(state_id(*plan_.things[i].room))}});
      xml_.empty("interConnects", {{"xlink:href", link_to(thing_id(i))}});
      xml_.empty("ConnectedLayers", {{"xlink:href", link_to("rooms")}});
      xml_.empty("ConnectedLayers", {{"xlink:href", link_to("things")}});
      close(2);
    }
    xml_.close();
  }

  const HomeContents& contents_;
  const PlanContents& plan_;
  XmlWriter xml_;
};

}  // namespace

Expected<IndoorPlan> indoor_gml(const HomeContents& contents) {
  if (contents.rooms.empty()) {
    return fail("no rooms are named, and a plan is of rooms; name them with roomwise rooms name");
  }
  if (!contents.floor.grid) {
    return fail(
        "the map shows no floor, so there is no plan; walk with the camera tilted down a "
        "little");
  }
  if (!contents.layout) {
    return fail(
        "no named place of the walk lies on free floor, so there is no plan; name the rooms "
        "of the walk, or walk with the camera tilted down a little");
  }
  const PlanContents plan(contents);
  IndoorPlan written;
  written.gml = IndoorGmlWriter(contents, plan).write();
  written.rooms = plan.rooms.size();
  written.doors = plan.doors_only;
  written.openings = plan.openings;
  written.stairs = plan.stairs.size();
  written.things = plan.things.size();
  written.rooms_without_place =
      static_cast<std::size_t>(std::ranges::count_if(contents.rooms, [&](const rooms::Room& room) {
        return std::ranges::find(plan.rooms, room.name, &RoomInPlan::name) == plan.rooms.end();
      }));
  written.stairs_without_rooms = plan.stairs_without_rooms;
  return written;
}

}  // namespace roomwise::pipeline
