#include "roomwise/pipeline/exports/walk_mcap.h"

#include <algorithm>
#include <map>
#include <optional>

#include "roomwise/guide/answers/room_prompts.h"
#include "roomwise/guide/places/home_map.h"
#include "roomwise/pipeline/exports/foxglove_json.h"
#include "roomwise/pipeline/exports/home_contents.h"
#include "roomwise/pipeline/exports/shared_picture.h"
#include "roomwise/pipeline/in_blocks.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/rooms/room_outline.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/recording/messages/mcap_writer.h"

namespace roomwise::pipeline {
namespace {

using recording::McapFileWriter;

const std::string kHomeFrame = "home", kCameraFrame = "camera";

std::uint16_t add_channel(McapFileWriter& writer, const std::string& topic,
                          const FoxgloveSchema& schema) {
  return writer.add_json_channel(topic, schema.name, schema.text);
}

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

struct Channels {
  std::uint16_t transform, image, calibration, prompts;

  static Channels add_to(McapFileWriter& writer, bool has_prompts) {
    Channels channels{add_channel(writer, "/tf", foxglove_transform_schema()),
                      add_channel(writer, "/camera/image", foxglove_image_schema()),
                      add_channel(writer, "/camera/calibration", foxglove_calibration_schema()), 0};
    if (has_prompts) channels.prompts = add_channel(writer, "/prompts", foxglove_log_schema());
    return channels;
  }
};

// Messages of one walk, in the order of time.
struct WalkToWrite {
  const home::Home& home;
  HomeContents contents;
  std::size_t index = 0;                  // of the walk in contents.walks
  std::vector<home::Keyframe> keyframes;  // on the largest component
  recording::Trajectory trajectory_world;
  std::map<TimestampNs, std::string> prompts;  // by the pose at which they are said

  [[nodiscard]] const WalkContent& walk() const { return contents.walks[index]; }
  [[nodiscard]] TimestampNs begin_ns() const {
    return std::min(keyframes.front().timestamp_ns, trajectory_world.front().timestamp_ns);
  }
};

// What is called out to whoever walks there, by the layout alone: what is said along the walk when
// the home looks at each picture depends on what it has learned of it.
std::map<TimestampNs, std::string> callouts_of(const HomeContents& contents,
                                               const recording::Trajectory& trajectory_world,
                                               const guide::Wording& wording) {
  std::map<TimestampNs, std::string> callouts;
  if (!contents.layout) return callouts;
  const guide::HomeMap map{.floor = &*contents.floor.grid, .layout = &*contents.layout};
  std::optional<std::string> said;
  for (const recording::StampedPose& pose : trajectory_world) {
    const Eigen::Vector3d place_gravity =
        contents.gravity_from_world() * pose.world_from_camera.translation;
    const Eigen::Vector2d place = contents.storeys().plan_from_gravity(place_gravity).head<2>();
    const auto room = contents.layout->room_at(place);
    if (!room || room == said || !guide::is_well_inside(map, *room, place)) continue;
    said = room;
    const rooms::RoomDecision decision{.verdict = rooms::Verdict::kRoom,
                                       .rooms = {{*room, 1}},
                                       .familiarity = 0,
                                       .why = "the walk came into it",
                                       .object = {}};
    if (const auto prompt = guide::entered_prompt(decision, wording, pose.timestamp_ns))
      callouts.emplace(pose.timestamp_ns, prompt->text);
  }
  return callouts;
}

std::vector<NamedOutline> outlines_of_rooms(const HomeContents& contents) {
  std::vector<NamedOutline> outlines;
  if (!contents.layout) return outlines;
  const fusion::FloorGrid& grid = *contents.floor.grid;
  const auto& extents = contents.layout->rooms();
  for (std::size_t i = 0; i < extents.size(); ++i) {
    if (extents[i].floor_m2 == 0) continue;
    NamedOutline outline{.id = fmt::format("room {}", i + 1),
                         .name = extents[i].name,
                         .name_at = contents.place_gravity(extents[i].middle_plan),
                         .rings = {}};
    const auto add = [&](const geometry::CellRing& ring) {
      auto& corners = outline.rings.emplace_back();
      for (const Eigen::Vector2i& corner : ring) {
        corners.push_back(
            contents.place_gravity(grid.origin_m() + grid.cell_m() * corner.cast<double>()));
      }
    };
    for (const geometry::CellPolygon& part :
         geometry::cell_outlines(room_cells(grid, *contents.layout, i))) {
      add(part.outer);
      std::ranges::for_each(part.holes, add);
    }
    outlines.push_back(std::move(outline));
  }
  return outlines;
}

Expected<WalkToWrite> walk_to_write(const home::Home& home, home::RecordingId id,
                                    const guide::Wording& wording, RunContext& run) {
  ROOMWISE_TRY(HomeContents contents, read_home_contents(home, run));
  const auto walk = std::ranges::find(contents.walks, id,
                                      [](const WalkContent& content) { return content.stored.id; });
  if (walk == contents.walks.end()) {
    return fail("{}: the home has no such walk, or it is taken away", home.file());
  }
  const auto index = static_cast<std::size_t>(walk - contents.walks.begin());
  WalkToWrite one{home, std::move(contents), index, {}, {}, {}};
  std::ranges::copy_if(one.walk().keyframes, std::back_inserter(one.keyframes),
                       [](const home::Keyframe& keyframe) { return keyframe.pose.component == 0; });
  if (one.keyframes.empty()) {
    return fail("{}: no key-frame of the walk {} is on the map's largest piece", home.file(),
                one.walk().stored.recording.name);
  }
  ROOMWISE_TRY(one.trajectory_world, stored_trajectory(home, id));
  one.prompts = callouts_of(one.contents, one.trajectory_world, wording);
  return one;
}

Expected<void> write_home(const WalkToWrite& one, double voxel_size_m, McapFileWriter& writer,
                          WalkLog& log, RunContext& run) {
  // On a topic of its own, at the begin.
  const auto write_once = [&](const std::string& topic, const FoxgloveSchema& schema,
                              const nlohmann::ordered_json& message) {
    return writer.write(add_channel(writer, topic, schema), one.begin_ns(), text_of(message));
  };
  ROOMWISE_TRY(const MapCloud map, build_map_cloud(one.home, voxel_size_m, run));
  geometry::PointCloud cloud = map.cloud;
  for (Eigen::Vector3f& point : cloud.points) {
    point =
        (one.contents.gravity_from_world() * Eigen::Vector3d(point.cast<double>())).cast<float>();
  }
  log.points = cloud.size();
  if (log.points > 0) {
    ROOMWISE_RETURN_IF_ERROR(write_once("/map", foxglove_cloud_schema(),
                                        foxglove_cloud(one.begin_ns(), kHomeFrame, cloud)));
  }
  std::vector<NamedBox> boxes;
  for (std::size_t i = 0; i < one.contents.things.size(); ++i) {
    const ThingContent& thing = one.contents.things[i];
    if (!thing.box_gravity) continue;
    boxes.push_back({fmt::format("thing {}", i + 1), thing.instance.name, *thing.box_gravity});
  }
  log.things = boxes.size();
  if (log.things > 0) {
    ROOMWISE_RETURN_IF_ERROR(write_once("/things", foxglove_scene_schema(),
                                        foxglove_scene(one.begin_ns(), kHomeFrame, boxes)));
  }
  const std::vector<NamedOutline> rooms = outlines_of_rooms(one.contents);
  log.rooms = rooms.size();
  if (log.rooms > 0) {
    ROOMWISE_RETURN_IF_ERROR(write_once("/rooms", foxglove_scene_schema(),
                                        foxglove_outlines(one.begin_ns(), kHomeFrame, rooms)));
  }
  return {};
}

// The poses up to a time, from where the last call stopped.
Expected<void> write_poses_until(TimestampNs time_ns, const WalkToWrite& one,
                                 const Channels& channels, McapFileWriter& writer, WalkLog& log) {
  for (; log.poses < one.trajectory_world.size(); ++log.poses) {
    const recording::StampedPose& pose = one.trajectory_world[log.poses];
    if (pose.timestamp_ns > time_ns) break;
    ROOMWISE_RETURN_IF_ERROR(writer.write(
        channels.transform, pose.timestamp_ns,
        text_of(foxglove_transform(pose.timestamp_ns, kHomeFrame, kCameraFrame,
                                   one.contents.gravity_from_world() * pose.world_from_camera))));
    const auto prompt = one.prompts.find(pose.timestamp_ns);
    if (prompt == one.prompts.end()) continue;
    ++log.prompts;
    ROOMWISE_RETURN_IF_ERROR(
        writer.write(channels.prompts, prompt->first,
                     text_of(foxglove_log(prompt->first, "roomwise", prompt->second))));
  }
  return {};
}

Expected<void> write_pictures(const WalkToWrite& one, const Channels& channels,
                              McapFileWriter& writer, WalkLog& log, RunContext& run) {
  return in_blocks(
      one.keyframes.size(), "writing the pictures", run,
      [&](std::size_t i) { return one.home.images(one.keyframes[i].id); },
      [&](std::size_t i, const home::KeyframeImages& images) -> Expected<std::string> {
        ROOMWISE_TRY(const Bytes picture, picture_to_share(images.color));
        return text_of(foxglove_image(one.keyframes[i].timestamp_ns, kCameraFrame, picture));
      },
      [&](std::size_t i, const std::string& message) -> Expected<void> {
        const TimestampNs time_ns = one.keyframes[i].timestamp_ns;
        ROOMWISE_RETURN_IF_ERROR(write_poses_until(time_ns, one, channels, writer, log));
        ROOMWISE_RETURN_IF_ERROR(
            writer.write(channels.calibration, time_ns,
                         text_of(foxglove_calibration(time_ns, kCameraFrame,
                                                      one.walk().stored.recording.camera))));
        ++log.pictures;
        return writer.write(channels.image, time_ns, message);
      });
}

}  // namespace

Expected<WalkLog> write_walk_mcap(const home::Home& home, home::RecordingId walk,
                                  const std::filesystem::path& path, const WalkLogOptions& options,
                                  RunContext& run) {
  const auto catalogue = guide::MessageCatalogue::built_in();
  guide::Wording wording{&catalogue, {}};
  wording.style.language = options.language;
  ROOMWISE_RETURN_IF_ERROR(wording.style.validate(catalogue));
  ROOMWISE_TRY(McapFileWriter writer, McapFileWriter::create(path));
  ROOMWISE_TRY(const WalkToWrite one, walk_to_write(home, walk, wording, run));
  WalkLog log;
  log.keyframes_apart = one.walk().keyframes.size() - one.keyframes.size();
  const Channels channels = Channels::add_to(writer, !one.prompts.empty());
  ROOMWISE_RETURN_IF_ERROR(write_home(one, options.voxel_size_m, writer, log, run));
  ROOMWISE_RETURN_IF_ERROR(write_pictures(one, channels, writer, log, run));
  ROOMWISE_RETURN_IF_ERROR(
      write_poses_until(one.trajectory_world.back().timestamp_ns, one, channels, writer, log));
  ROOMWISE_RETURN_IF_ERROR(writer.finish());
  return log;
}

}  // namespace roomwise::pipeline
