#include "roomwise/live/routes/edit_routes.h"

#include <algorithm>

#include "roomwise/live/routes/home_json.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/thing_target.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/service/protocol/json_members.h"

namespace roomwise::live {
namespace {

using service::HttpAnswer;
using service::HttpRequest;
using service::Members;
using service::Placeholders;
using service::Role;

constexpr double kFarthest_m = 10'000;  // what is farther is a fault
constexpr std::size_t kMaxNoteBytes = 1'000;

// The words of a change that is asked for, and what it is made with.
struct Asked {
  const service::OrderedJson& json;
  home::Home& home;
  const HomeView& view;
  const pipeline::EditAuthor& author;
  const RoomPhotos& photos;
};
using Outcome = Expected<home::EditId>;

Expected<std::string> asked_text(const Asked& asked, const char* name,
                                 std::size_t max_bytes = service::kMaxWordBytes) {
  Members members(asked.json);
  return members.finish(members.text(name, max_bytes));
}

Expected<pipeline::HomeThing> asked_thing(const Asked& asked, const char* name) {
  Members members(asked.json);
  ROOMWISE_TRY(const std::int64_t id,
               members.finish(members.integer(name, 0, service::kMaxInteger)));
  ROOMWISE_TRY(auto things, pipeline::find_home_things(asked.home));
  const auto found =
      std::ranges::find_if(things.things, [&](const auto& one) { return thing_id(one) == id; });
  if (found == things.things.end()) {
    return fail("this home has no thing {} any more; look at it anew", id);
  }
  return std::move(*found);
}

Expected<std::vector<Eigen::Vector2d>> asked_points(const Asked& asked, const char* name) {
  const auto wrong = [&] { return fail("'{}' must be a list of points [x, y], in metres", name); };
  const auto list = asked.json.find(name);
  if (list == asked.json.end() || !list->is_array()) return wrong();
  std::vector<Eigen::Vector2d> points;
  for (const service::OrderedJson& one : *list) {
    if (!one.is_array() || one.size() != 2 || !one[0].is_number() || !one[1].is_number()) {
      return wrong();
    }
    points.emplace_back(one[0].get<double>(), one[1].get<double>());
    if (!(points.back().array().abs() <= kFarthest_m).all()) return wrong();
  }
  return points;
}

Expected<pipeline::FloorLine> asked_line(const Asked& asked) {
  ROOMWISE_TRY(const auto ends, asked_points(asked, "line"));
  if (ends.size() != 2) return fail("'line' must be two points");
  return pipeline::FloorLine{ends[0], ends[1]};
}

Expected<const LiveMap*> ready_map(const Asked& asked) {
  if (asked.view.map) return asked.view.map.get();
  return fail("the map is not ready yet; try again soon");
}

Expected<pipeline::HomeFloor> asked_floor(const Asked& asked) {
  ROOMWISE_TRY(const LiveMap* const map, ready_map(asked));
  return pipeline::HomeFloor{map->frame, map->floor};
}

Expected<pipeline::ThingTarget> asked_target(const Asked& asked, const std::string& name,
                                             const pipeline::HomeThing* before) {
  pipeline::SaidPlace where;
  Members members(asked.json);
  if (members.has("position")) {
    const auto at = members.numbers("position", 2, -kFarthest_m, kFarthest_m);
    if (!members.error()) where.point_plan = {at[0], at[1]};
  }
  if (members.has("height")) where.height_m = members.number("height", -kFarthest_m, kFarthest_m);
  if (members.has("room")) where.room = members.text("room");
  if (members.error()) return Unexpected(Error(*members.error()));
  ROOMWISE_TRY(const LiveMap* const map, ready_map(asked));
  return pipeline::target_of(asked.home, map->frame,
                             asked.view.layout ? &*asked.view.layout : nullptr, where, name,
                             before);
}

Outcome add_thing(const Asked& asked) {
  ROOMWISE_TRY(const std::string name, asked_text(asked, "name"));
  std::string note;
  if (Members(asked.json).has("note")) {
    ROOMWISE_TRY(note, asked_text(asked, "note", kMaxNoteBytes));
  }
  ROOMWISE_TRY(const auto where, asked_target(asked, name, nullptr));
  return pipeline::add_thing(asked.home, asked.author, name, where, note);
}

Outcome rename_thing(const Asked& asked) {
  ROOMWISE_TRY(const auto renamed, asked_thing(asked, "thing"));
  ROOMWISE_TRY(const std::string name, asked_text(asked, "name"));
  return pipeline::rename_thing(asked.home, asked.author, renamed, name);
}

Outcome note_on_thing(const Asked& asked) {
  ROOMWISE_TRY(const auto noted, asked_thing(asked, "thing"));
  ROOMWISE_TRY(const std::string note, asked_text(asked, "note", kMaxNoteBytes));
  return pipeline::note_thing(asked.home, asked.author, noted, note);
}

Outcome move_thing(const Asked& asked) {
  ROOMWISE_TRY(const auto moved, asked_thing(asked, "thing"));
  ROOMWISE_TRY(const auto where, asked_target(asked, moved.name, &moved));
  return pipeline::move_thing(asked.home, asked.author, moved, where);
}

Outcome merge_things(const Asked& asked) {
  ROOMWISE_TRY(const auto kept, asked_thing(asked, "thing"));
  ROOMWISE_TRY(const auto twin, asked_thing(asked, "double"));
  return pipeline::merge_things(asked.home, asked.author, kept, twin);
}

Outcome remove_thing(const Asked& asked) {
  ROOMWISE_TRY(const auto removed, asked_thing(asked, "thing"));
  return pipeline::remove_thing(asked.home, asked.author, removed);
}

Outcome join_rooms(const Asked& asked) {
  ROOMWISE_TRY(const std::string kept, asked_text(asked, "room"));
  ROOMWISE_TRY(const std::string joined, asked_text(asked, "other_room"));
  ROOMWISE_RETURN_IF_ERROR(asked.photos.check_can_join(kept, joined));
  return pipeline::join_rooms(asked.home, asked.author, kept, joined);
}

Outcome divide_room(const Asked& asked) {
  ROOMWISE_TRY(const std::string room, asked_text(asked, "room"));
  ROOMWISE_TRY(const std::string new_room, asked_text(asked, "other_room"));
  ROOMWISE_TRY(const auto along, asked_line(asked));
  ROOMWISE_TRY(const auto on, asked_floor(asked));
  return pipeline::divide_room(asked.home, asked.author, on, room, along, new_room);
}

Outcome move_border(const Asked& asked) {
  ROOMWISE_TRY(const std::string left, asked_text(asked, "room"));
  ROOMWISE_TRY(const std::string right, asked_text(asked, "other_room"));
  ROOMWISE_TRY(const auto along, asked_line(asked));
  ROOMWISE_TRY(const auto on, asked_floor(asked));
  return pipeline::move_border(asked.home, asked.author, on, left, right, along);
}

Outcome draw_room(const Asked& asked) {
  ROOMWISE_TRY(const std::string room, asked_text(asked, "room"));
  ROOMWISE_TRY(const auto outline, asked_points(asked, "outline"));
  ROOMWISE_TRY(const auto on, asked_floor(asked));
  return pipeline::draw_room(asked.home, asked.author, on, room, outline);
}

Outcome add_door(const Asked& asked) {
  ROOMWISE_TRY(const std::string room, asked_text(asked, "room"));
  ROOMWISE_TRY(const std::string other, asked_text(asked, "other_room"));
  Members members(asked.json);
  ROOMWISE_TRY(const auto at,
               members.finish(members.numbers("position", 2, -kFarthest_m, kFarthest_m)));
  ROOMWISE_TRY(const auto on, asked_floor(asked));
  return pipeline::add_door(asked.home, asked.author, on, {room, other}, {at[0], at[1]});
}

// It goes for good by POST /api/erase, or when `serve` ends.
Outcome take_walk_away(const Asked& asked) {
  Members members(asked.json);
  ROOMWISE_TRY(const std::int64_t walk,
               members.finish(members.integer("walk", 0, service::kMaxInteger)));
  return pipeline::take_walk_away(asked.home, asked.author, walk);
}

// Changes of rooms that have files beside the home go by requests of their own.
Outcome do_asked(const std::string& what, const Asked& asked) {
  constexpr std::array kChanges{
      std::pair{"add thing", &add_thing},       std::pair{"rename thing", &rename_thing},
      std::pair{"note", &note_on_thing},        std::pair{"move thing", &move_thing},
      std::pair{"merge things", &merge_things}, std::pair{"remove thing", &remove_thing},
      std::pair{"join rooms", &join_rooms},     std::pair{"divide room", &divide_room},
      std::pair{"move border", &move_border},   std::pair{"draw room", &draw_room},
      std::pair{"add door", &add_door},         std::pair{"take walk away", &take_walk_away}};
  for (const auto& [name, change] : kChanges) {
    if (what == name) return change(asked);
  }
  return fail("'what' must be a change of things, rooms or walks; '{}' is none", what);
}

HttpAnswer make_change(LiveHome& home, const HttpRequest& request) {
  const auto parsed = service::json_of(request);
  if (!parsed) return service::error_answer(400, parsed.error().message);
  const service::OrderedJson json = *parsed;
  Members members(json);
  const std::string what = members.text("what");
  if (members.error()) return service::error_answer(400, members.error()->message);
  const auto done =
      home.edit(request.who ? request.who->name : "",
                [&](home::Home& open, const HomeView& view, const pipeline::EditAuthor& author) {
                  return do_asked(what, {json, open, view, author, home.photos()});
                });
  if (!done) return service::error_answer(409, done.error().message);
  return service::json_answer({{"edit", *done}});
}

HttpAnswer undo_change(LiveHome& home, const Placeholders& values) {
  const auto id = service::number_of<home::EditId>(values.at("id"));
  if (!id) return service::error_answer(404, "this is no change's number");
  const auto done = home.undo(*id);
  if (!done) return service::error_answer(409, done.error().message);
  return service::json_answer(Json::object());
}

}  // namespace

std::vector<HomeRoute> edit_routes() {
  return {{"GET", "/api/map/plan", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             return service::json_answer(plan_json(*home.view()));
           }},
          {"POST", "/api/edits", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const auto&) {
             return make_change(home, request);
           }},
          {"GET", "/api/edits", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             return service::json_answer(edits_json(*home.view()));
           }},
          {"DELETE", "/api/edits/{id}", Role::kHelper,
           [](LiveHome& home, const HttpRequest&, const Placeholders& values) {
             return undo_change(home, values);
           }}};
}

}  // namespace roomwise::live
