#include "roomwise/pipeline/edits/thing_target.h"

#include <algorithm>

#include "roomwise/objects/kinds/kinds.h"
#include "roomwise/pipeline/edits/map_extent.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

Expected<Eigen::Vector2d> middle_of_room(const home::Home& home,
                                         const fusion::GravityAlignedFrame& frame,
                                         const rooms::RoomLayout* layout, const std::string& room) {
  ROOMWISE_TRY(const auto known, home.rooms());
  if (std::ranges::find(known, room, &rooms::Room::name) == known.end()) {
    return fail("this home has no room '{}'", room);
  }
  if (layout != nullptr) {
    const auto extent = std::ranges::find(layout->rooms(), room, &rooms::RoomExtent::name);
    if (extent != layout->rooms().end() && extent->floor_m2 > 0) return extent->middle_plan;
  }
  ROOMWISE_TRY(const KeyframeRooms rooms, rooms_of_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::vector<Eigen::Vector2d> stood;
  for (const auto& [id, name] : rooms) {
    const home::KeyframePose& pose = keyframes[id].pose;
    if (name != room || pose.component != 0) continue;
    stood.push_back(frame.on_plan(pose.world_from_keyframe.translation).head<2>());
  }
  if (stood.empty()) return fail("no walk shows where the room {} lies; give a place", room);
  return stood[stood.size() / 2];
}

double height_of(const fusion::GravityAlignedFrame& frame, const std::string& name,
                 const std::optional<Eigen::Vector3d>& before_world) {
  if (before_world) return frame.on_plan(*before_world).z();
  constexpr double kTable_m = 0.75;
  const objects::Kind* const kind = objects::find_kind(name);
  const double half_m = objects::usual_size_m(name).z() / 2;
  return kind != nullptr && kind->stands_on_floor ? half_m : kTable_m + half_m;
}

}  // namespace

Expected<ThingTarget> target_of(const home::Home& home, const fusion::GravityAlignedFrame& frame,
                                const rooms::RoomLayout* layout, const SaidPlace& where,
                                const std::string& name, const HomeThing* before) {
  if (where.point_plan && !where.point_plan->allFinite()) {
    return fail("the place is not made of finite numbers");
  }
  if (!where.point_plan && where.room.empty()) {
    return fail("a thing needs a place: a point on the floor, or a room");
  }
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  if (where.point_plan) {
    point = *where.point_plan;
  } else {
    ROOMWISE_TRY(point, middle_of_room(home, frame, layout, where.room));
  }
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::optional<Eigen::Vector3d> before_world;
  if (before != nullptr) {
    const home::KeyframePose& pose = keyframes[before->keyframe_id].pose;
    if (pose.component == 0) before_world = before->box_world(pose.world_from_keyframe).center();
  }
  const double height_m = where.height_m ? *where.height_m : height_of(frame, name, before_world);
  const Eigen::Vector3d place_plan(point.x(), point.y(), height_m);
  ROOMWISE_RETURN_IF_ERROR(check_near_map(keyframes, frame, place_plan));
  return ThingTarget{frame.world_from_plan(place_plan), where.room};
}

}  // namespace roomwise::pipeline
