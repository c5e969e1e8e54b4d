#include <filesystem>
#include <memory>

#include "commands.h"
#include "roomwise/home/home.h"

namespace roomwise::app {
namespace {

// An object with what the rest of the home says about it.
struct PlacedObject {
  objects::MapObject object;
  home::Keyframe keyframe;
  std::optional<Eigen::Vector3d> position_world;
  std::string room;  // empty: not known
};

Expected<std::vector<PlacedObject>> placed_objects(const home::Home& home) {
  ROOMWISE_TRY(const std::vector<objects::MapObject> objects, home.objects());
  ROOMWISE_TRY(const std::vector<home::Keyframe> keyframes, home.keyframes());
  ROOMWISE_TRY(const auto rooms, home.keyframe_rooms());
  std::map<home::KeyframeId, home::Keyframe> by_id;
  for (const home::Keyframe& keyframe : keyframes) by_id[keyframe.id] = keyframe;

  std::vector<PlacedObject> placed;
  for (const objects::MapObject& object : objects) {
    PlacedObject& entry = placed.emplace_back();
    entry.object = object;
    entry.keyframe = by_id.at(object.keyframe_id);
    if (object.position_keyframe) {
      entry.position_world = entry.keyframe.pose.world_from_keyframe * *object.position_keyframe;
    }
    const auto room = rooms.find(object.keyframe_id);
    if (room != rooms.end() && !room->second.empty()) entry.room = room->second.front().room;
  }
  return placed;
}

std::string describe(const PlacedObject& entry) {
  const auto& position = entry.position_world;
  return fmt::format("{:<16} {:.2f}  in {} key-frames, best {} (frame {})  {}{}\n",
                     entry.object.name, entry.object.score, entry.object.sightings,
                     entry.object.keyframe_id, entry.keyframe.frame_index,
                     position ? fmt::format("at {:.2f} {:.2f} {:.2f} m", position->x(),
                                            position->y(), position->z())
                              : "place not known",
                     entry.room.empty() ? "" : ", " + entry.room);
}

Json to_json(const PlacedObject& entry) {
  const auto& position = entry.position_world;
  return {{"name", entry.object.name},
          {"score", entry.object.score},
          {"sightings", entry.object.sightings},
          {"keyframe", entry.object.keyframe_id},
          {"frame", entry.keyframe.frame_index},
          {"piece", entry.keyframe.pose.piece},
          {"position_world_m",
           position ? Json{position->x(), position->y(), position->z()} : Json(nullptr)},
          {"room", entry.room.empty() ? Json(nullptr) : Json(entry.room)}};
}

Expected<Answer> list(const std::filesystem::path& path) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(path));
  ROOMWISE_TRY(const std::vector<PlacedObject> objects, placed_objects(home));
  Answer answer;
  answer.json = {{"objects", Json::array()}};
  for (const PlacedObject& entry : objects) {
    answer.text += describe(entry);
    answer.json["objects"].push_back(to_json(entry));
  }
  if (objects.empty()) answer.text = "no objects were found in this home\n";
  return answer;
}

}  // namespace

void add_objects_commands(CLI::App& app, Context& context) {
  CLI::App* group = add_group(app, "objects", "The objects that were found in a home",
                              "roomwise objects list --home my.home");
  auto home = std::make_shared<std::filesystem::path>();
  CLI::App* command = add_command(
      *group, context, "list", "List the objects with score, place and the room they stand in",
      "roomwise objects list --home my.home --json", [home] { return list(*home); });
  command->add_option("--home", *home, "Home file")->required();
}

}  // namespace roomwise::app
