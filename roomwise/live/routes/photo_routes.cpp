#include "roomwise/live/routes/photo_routes.h"

#include <nlohmann/json.hpp>

namespace roomwise::live {
namespace {

using service::HttpAnswer;
using service::HttpRequest;
using service::Placeholders;

constexpr std::size_t kMaxPhotoBytes = std::size_t{20} << 20U;

HttpAnswer list_photos(LiveHome& home) {
  const auto counts = home.photos().counts();
  if (!counts) return service::error_answer(500, counts.error().message);
  nlohmann::json rooms = nlohmann::json::array();
  for (const RoomPhotos::Count& one : *counts) {
    rooms.push_back({{"room", one.room}, {"photos", one.photos}});
  }
  return service::json_answer({{"rooms", rooms}, {"wanted", RoomPhotos::kPerRoom}});
}

HttpAnswer add_photo(LiveHome& home, const HttpRequest& request, const Placeholders& values) {
  const std::string& room = values.at("name");
  const auto photos = home.photos().add(room, request.body);
  if (!photos) return service::error_answer(409, photos.error().message);
  return service::json_answer(
      {{"room", room}, {"photos", *photos}, {"wanted", RoomPhotos::kPerRoom}});
}

}  // namespace

std::vector<HomeRoute> photo_routes() {
  constexpr auto kHelper = service::Role::kHelper;
  return {{"GET", "/api/photos", kHelper,
           [](LiveHome& home, const auto&, const auto&) { return list_photos(home); }},
          {"POST", "/api/rooms/{name}/photos", kHelper,
           [](LiveHome& home, const HttpRequest& request, const Placeholders& values) {
             return add_photo(home, request, values);
           },
           kMaxPhotoBytes},
          {"DELETE", "/api/rooms/{name}/photos", kHelper,
           [](LiveHome& home, const HttpRequest&, const Placeholders& values) {
             const auto removed = home.photos().remove(values.at("name"));
             if (!removed) return service::error_answer(409, removed.error().message);
             return service::json_answer(nlohmann::json::object());
           }}};
}

}  // namespace roomwise::live
