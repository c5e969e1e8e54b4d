#include "roomwise/live/routes/coverage_routes.h"

#include "roomwise/base/calendar_time.h"
#include "roomwise/live/routes/home_json.h"

namespace roomwise::live {
namespace {

using pipeline::CoverageItem;
using pipeline::Missing;

Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

// Since 1970; null where the stamp tells no date.
Json seconds_or_null(TimestampNs time_ns) {
  return calendar_time(time_ns) ? Json(time_ns / 1'000'000'000) : Json(nullptr);
}

// How many pictures would do.
Json wanted(const CoverageItem& item, const rooms::LearningOptions& learning) {
  if (item.what == Missing::kPictures) return learning.min_pictures;
  if (item.what == Missing::kMorePictures) return learning.comfortable_pictures;
  return nullptr;
}

Json gap_json(const pipeline::FloorGap& gap) {
  return {{"place", {gap.middle_plan.x(), gap.middle_plan.y()}},
          {"length_m", gap.length_m},
          {"unseen", gap.is_unseen},
          {"beside", text_or_null(gap.beside)}};
}

Json room_json(const pipeline::RoomSeen& room) {
  Json walks = Json::array();
  for (const pipeline::RoomOnWalk& one : room.walks) {
    walks.push_back(
        {{"walk", one.walk}, {"pictures", one.pictures}, {"time", seconds_or_null(one.first_ns)}});
  }
  return {{"room", room.room}, {"pictures", room.pictures()}, {"walks", std::move(walks)}};
}

Json coverage_json(const pipeline::RoomCoverage& coverage) {
  const pipeline::CoverageOptions options;
  Json missing = Json::array(), rooms = Json::array();
  for (const CoverageItem& item : pipeline::missing_items(coverage, options)) {
    missing.push_back({{"what", pipeline::to_string(item.what)},
                       {"room", text_or_null(item.room)},
                       {"walk", item.walk ? Json(*item.walk) : Json(nullptr)},
                       {"pictures", item.pictures},
                       {"wanted", wanted(item, options.learning)},
                       {"floor", item.gap ? gap_json(*item.gap) : Json(nullptr)}});
  }
  for (const pipeline::RoomSeen& room : coverage.rooms) rooms.push_back(room_json(room));
  return {{"missing", std::move(missing)},
          {"rooms", std::move(rooms)},
          {"floor_known", coverage.knows_floor}};
}

}  // namespace

std::vector<HomeRoute> coverage_routes() {
  return {{"GET", "/api/coverage", service::Role::kHelper,
           [](LiveHome& home, const auto&, const auto&) {
             const auto coverage = home.coverage();
             if (!coverage) return service::error_answer(500, coverage.error().message);
             if (*coverage == nullptr) {
               return service::error_answer(
                   503, "what is missing is being worked out, or the map is; ask again soon");
             }
             return service::json_answer(coverage_json(**coverage));
           }}};
}

}  // namespace roomwise::live
