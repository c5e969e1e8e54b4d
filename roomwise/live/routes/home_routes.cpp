#include "roomwise/live/routes/home_routes.h"

#include <algorithm>

#include "roomwise/image/codec.h"
#include "roomwise/live/routes/coverage_routes.h"
#include "roomwise/live/routes/edit_routes.h"
#include "roomwise/live/routes/home_json.h"
#include "roomwise/live/routes/photo_routes.h"
#include "roomwise/live/routes/trial_routes.h"
#include "roomwise/live/routes/upload_routes.h"
#include "roomwise/service/protocol/json_members.h"

namespace roomwise::live {
namespace {

using service::error_answer;
using service::HttpAnswer;
using service::HttpRequest;
using service::json_answer;
using service::Placeholders;
using service::Role;

constexpr std::size_t kMaxPictureBytes = std::size_t{20} << 20U;

// 200, or 409 with the reason: the home is as it was.
HttpAnswer done(const Expected<void>& outcome) {
  if (!outcome) return error_answer(409, outcome.error().message);
  return json_answer(Json::object());
}

std::string name_of(const HttpRequest& request) {
  return request.who ? request.who->name : std::string();
}

HttpAnswer bad(const Error& error) {
  return error_answer(400, error.message);
}

HttpAnswer picture_answer(Bytes bytes) {
  HttpAnswer answer;
  answer.content_type = image::is_png(bytes) ? "image/png" : "image/jpeg";
  answer.body = std::move(bytes);
  return answer;
}

// A handler whose path ends with a number.
template <typename Handle>
auto numbered(const char* placeholder, Handle handle) {
  return [placeholder, handle](LiveHome& home, const HttpRequest& request,
                               const Placeholders& values) {
    const auto number = service::number_of<std::int64_t>(values.at(placeholder));
    if (!number || *number < 0) {
      return error_answer(404, fmt::format("'{}' is no number", values.at(placeholder)));
    }
    return handle(home, request, *number);
  };
}

Expected<std::vector<recording::RoomRange>> read_ranges(const HttpRequest& request) {
  ROOMWISE_TRY(const auto parsed, service::json_of(request));
  const service::OrderedJson json = parsed;
  if (!json.contains("ranges") || !json["ranges"].is_array()) {
    return fail("'ranges' must be a list of {{first, last, room}}");
  }
  std::vector<recording::RoomRange> ranges;
  for (const service::OrderedJson& one : json["ranges"]) {
    if (!one.is_object()) return fail("'ranges' must be a list of {{first, last, room}}");
    service::Members members(one);
    recording::RoomRange range;
    range.first_frame =
        static_cast<std::uint64_t>(members.integer("first", 0, service::kMaxInteger));
    range.last_frame = static_cast<std::uint64_t>(members.integer("last", 0, service::kMaxInteger));
    range.room = members.text("room");
    if (members.error()) return Unexpected(Error(*members.error()));
    ranges.push_back(std::move(range));
  }
  return ranges;
}

// The texts of a body, of which each may be missing.
Expected<std::map<std::string, std::string>> read_texts(const HttpRequest& request,
                                                        std::initializer_list<const char*> names) {
  ROOMWISE_TRY(const auto parsed, service::json_of(request));
  const service::OrderedJson json = parsed;
  service::Members members(json);
  std::map<std::string, std::string> texts;
  for (const char* name : names) {
    if (members.has(name)) texts[name] = members.text(name);
  }
  if (members.error()) return Unexpected(Error(*members.error()));
  return texts;
}

std::optional<std::string> find(const std::map<std::string, std::string>& texts,
                                const std::string& name) {
  const auto found = texts.find(name);
  return found != texts.end() ? std::optional(found->second) : std::nullopt;
}

// A handler that sends one of the map's clouds.
auto cloud_of(geometry::PointCloud MapClouds::*cloud) {
  return [cloud](LiveHome& home, const HttpRequest&, const Placeholders&) {
    const auto view = home.view();
    if (!view->map || !view->map->clouds)
      return error_answer(503, "the map is not ready yet; try again soon");
    HttpAnswer answer;
    answer.content_type = "application/octet-stream";
    answer.body = cloud_bytes((*view->map->clouds).*cloud);
    return answer;
  };
}

std::vector<HomeRoute> looking_routes() {
  return {{"GET", "/api/home", Role::kDevice,
           [](LiveHome& home, const auto& request, const auto&) {
             const Role role = request.who->role;
             Json json = home_json(*home.view(), role);
             if (role == Role::kHelper) json["walk_waits"] = home.walk_waits();
             return json_answer(json);
           }},
          {"GET", "/api/map/keyframes", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             return json_answer(keyframes_json(*home.view()));
           }},
          {"GET", "/api/map/cloud", Role::kHelper, cloud_of(&MapClouds::coarse)},
          {"GET", "/api/map/cloud/fine", Role::kHelper, cloud_of(&MapClouds::fine)},
          {"GET", "/api/keyframes/{id}/picture", Role::kHelper,
           numbered("id",
                    [](LiveHome& home, const HttpRequest&, std::int64_t id) {
                      auto picture = home.keyframe_picture(static_cast<home::KeyframeId>(id));
                      if (!picture) return error_answer(404, picture.error().message);
                      return picture_answer(*std::move(picture));
                    })},
          {"POST", "/api/test", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const auto&) {
             const auto decision = home.test_picture(request.body);
             return decision ? json_answer(decision_json(*decision)) : bad(decision.error());
           },
           kMaxPictureBytes},
          {"GET", "/api/recognitions", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             return json_answer(recognitions_json(home.recognitions().newest_first()));
           }},
          {"GET", "/api/recognitions/{number}/picture", Role::kHelper,
           numbered("number", [](LiveHome& home, const HttpRequest&, std::int64_t number) {
             auto picture = home.recognitions().picture(static_cast<std::uint64_t>(number));
             if (!picture) return error_answer(404, "this picture is not kept any more");
             return picture_answer(*std::move(picture));
           })}};
}

std::vector<HomeRoute> changing_routes() {
  return {{"PUT", "/api/recordings/{id}/rooms", Role::kHelper,
           numbered("id",
                    [](LiveHome& home, const HttpRequest& request, std::int64_t id) {
                      auto ranges = read_ranges(request);
                      if (!ranges) return bad(ranges.error());
                      return done(home.name_rooms(id, *std::move(ranges), name_of(request)));
                    })},
          {"PUT", "/api/rooms/{name}", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const Placeholders& values) {
             const auto texts = read_texts(request, {"name", "type"});
             if (!texts) return bad(texts.error());
             return done(home.change_room(values.at("name"), find(*texts, "name"),
                                          find(*texts, "type"), name_of(request)));
           }},
          {"DELETE", "/api/rooms/{name}", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const Placeholders& values) {
             return done(home.forget_room(values.at("name"), name_of(request)));
           }},
          {"PUT", "/api/things/{id}", Role::kHelper,
           numbered("id",
                    [](LiveHome& home, const HttpRequest& request, std::int64_t id) {
                      const auto texts = read_texts(request, {"name"});
                      if (!texts) return bad(texts.error());
                      return done(home.rename_thing(id, find(*texts, "name").value_or(""),
                                                    name_of(request)));
                    })},
          {"DELETE", "/api/things/{id}", Role::kHelper,
           numbered("id",
                    [](LiveHome& home, const HttpRequest& request, std::int64_t id) {
                      return done(home.forget_thing(id, name_of(request)));
                    })},
          {"DELETE", "/api/recordings/{id}", Role::kHelper,
           numbered("id", [](LiveHome& home, const HttpRequest&,
                             std::int64_t id) { return done(home.forget_walk(id)); })},
          {"POST", "/api/erase", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) { return done(home.erase_now()); }},
          {"DELETE", "/api/home", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const auto&) {
             const auto texts = read_texts(request, {"really"});
             if (!texts) return bad(texts.error());
             const std::string name = home.view()->name;
             if (find(*texts, "really") != name) {
               return error_answer(400, fmt::format("'really' must be the home's name, {}", name));
             }
             return done(home.forget_home());
           }}};
}

std::vector<HomeRoute> working_routes() {
  return {{"POST", "/api/learn", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) { return done(home.learn()); }},
          {"GET", "/api/job", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             const auto state = home.jobs().state();
             if (!state) return json_answer({{"state", "none"}});
             return json_answer(Json::parse(write(service::HomeMessage(*state))));
           }},
          {"POST", "/api/job/stop", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             if (!home.jobs().stop()) return error_answer(409, "nothing is being done");
             return json_answer(Json::object());
           }},
          {"POST", "/api/job/go_on", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) { return done(home.go_on_mapping()); }},
          {"POST", "/api/recording", Role::kHelper,
           [](LiveHome& home, const HttpRequest& request, const auto&) {
             const auto parsed = service::json_of(request);
             if (!parsed) return bad(parsed.error());
             const service::OrderedJson json = *parsed;
             service::Members members(json);
             const std::int64_t device = members.integer("device", 0, service::kMaxInteger);
             const std::string name = members.text("name");
             if (members.error()) return bad(*members.error());
             return done(home.begin_recording(device, name));
           }},
          {"POST", "/api/recording/stop", Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) { return done(home.end_recording()); }}};
}

}  // namespace

std::vector<HomeRoute> home_routes() {
  std::vector<HomeRoute> routes = looking_routes();
  std::ranges::move(changing_routes(), std::back_inserter(routes));
  std::ranges::move(working_routes(), std::back_inserter(routes));
  std::ranges::move(coverage_routes(), std::back_inserter(routes));
  std::ranges::move(edit_routes(), std::back_inserter(routes));
  std::ranges::move(trial_routes(), std::back_inserter(routes));
  std::ranges::move(upload_routes(), std::back_inserter(routes));
  std::ranges::move(photo_routes(), std::back_inserter(routes));
  return routes;
}

std::vector<service::Route> home_routes(LiveHome& home) {
  std::vector<service::Route> routes;
  for (HomeRoute& one : home_routes()) {
    routes.push_back({std::move(one.method), std::move(one.pattern), one.role,
                      [&home, handler = std::move(one.handler)](const HttpRequest& request,
                                                                const Placeholders& values) {
                        return handler(home, request, values);
                      },
                      one.max_body_bytes, one.is_audited});
  }
  return routes;
}

}  // namespace roomwise::live
