#include "roomwise/pipeline/exports/walk_mcap.h"

#include <algorithm>

#include "roomwise/pipeline/exports/foxglove_json.h"
#include "roomwise/pipeline/exports/home_contents.h"
#include "roomwise/pipeline/exports/shared_picture.h"
#include "roomwise/pipeline/in_blocks.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
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
  std::uint16_t transform, image, calibration, cloud, scene;

  static Channels add_to(McapFileWriter& writer) {
    return {add_channel(writer, "/tf", foxglove_transform_schema()),
            add_channel(writer, "/camera/image", foxglove_image_schema()),
            add_channel(writer, "/camera/calibration", foxglove_calibration_schema()),
            add_channel(writer, "/map", foxglove_cloud_schema()),
            add_channel(writer, "/things", foxglove_scene_schema())};
  }
};

// Messages of one walk, in the order of time.
struct WalkToWrite {
  const home::Home& home;
  HomeContents contents;
  std::size_t index = 0;                  // of the walk in contents.walks
  std::vector<home::Keyframe> keyframes;  // on the largest component
  recording::Trajectory trajectory_world;

  [[nodiscard]] const WalkContent& walk() const { return contents.walks[index]; }
  [[nodiscard]] TimestampNs begin_ns() const {
    return std::min(keyframes.front().timestamp_ns, trajectory_world.front().timestamp_ns);
  }
};

Expected<WalkToWrite> walk_to_write(const home::Home& home, home::RecordingId id, RunContext& run) {
  ROOMWISE_TRY(HomeContents contents, read_home_contents(home, run));
  const auto walk = std::ranges::find(contents.walks, id,
                                      [](const WalkContent& content) { return content.stored.id; });
  if (walk == contents.walks.end()) return fail("{}: the home has no such walk", home.file());
  const auto index = static_cast<std::size_t>(walk - contents.walks.begin());
  WalkToWrite one{home, std::move(contents), index, {}, {}};
  std::ranges::copy_if(one.walk().keyframes, std::back_inserter(one.keyframes),
                       [](const home::Keyframe& keyframe) { return keyframe.pose.component == 0; });
  if (one.keyframes.empty()) {
    return fail("{}: no key-frame of the walk {} is on the map's largest piece", home.file(),
                one.walk().stored.recording.name);
  }
  ROOMWISE_TRY(one.trajectory_world, stored_trajectory(home, id));
  return one;
}

Expected<void> write_home(const WalkToWrite& one, double voxel_size_m, const Channels& channels,
                          McapFileWriter& writer, WalkLog& log, RunContext& run) {
  ROOMWISE_TRY(const MapCloud map, build_map_cloud(one.home, voxel_size_m, run));
  geometry::PointCloud cloud = map.cloud;
  for (Eigen::Vector3f& point : cloud.points) {
    point =
        (one.contents.gravity_from_world() * Eigen::Vector3d(point.cast<double>())).cast<float>();
  }
  log.points = cloud.size();
  ROOMWISE_CHECK_OK(writer.write(channels.cloud, one.begin_ns(),
                                 text_of(foxglove_cloud(one.begin_ns(), kHomeFrame, cloud))));
  std::vector<NamedBox> boxes;
  for (std::size_t i = 0; i < one.contents.things.size(); ++i) {
    const ThingContent& thing = one.contents.things[i];
    if (!thing.box_gravity) continue;
    boxes.push_back({fmt::format("thing {}", i + 1), thing.instance.name, *thing.box_gravity});
  }
  log.things = boxes.size();
  return writer.write(channels.scene, one.begin_ns(),
                      text_of(foxglove_scene(one.begin_ns(), kHomeFrame, boxes)));
}

// The poses up to a time, from where the last call stopped.
Expected<void> write_poses_until(TimestampNs time_ns, const WalkToWrite& one,
                                 const Channels& channels, McapFileWriter& writer, WalkLog& log) {
  for (; log.poses < one.trajectory_world.size(); ++log.poses) {
    const recording::StampedPose& pose = one.trajectory_world[log.poses];
    if (pose.timestamp_ns > time_ns) break;
    ROOMWISE_CHECK_OK(writer.write(
        channels.transform, pose.timestamp_ns,
        text_of(foxglove_transform(pose.timestamp_ns, kHomeFrame, kCameraFrame,
                                   one.contents.gravity_from_world() * pose.world_from_camera))));
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
        ROOMWISE_CHECK_OK(write_poses_until(time_ns, one, channels, writer, log));
        ROOMWISE_CHECK_OK(
            writer.write(channels.calibration, time_ns,
                         text_of(foxglove_calibration(time_ns, kCameraFrame,
                                                      one.walk().stored.recording.camera))));
        ++log.pictures;
        return writer.write(channels.image, time_ns, message);
      });
}

}  // namespace

Expected<WalkLog> write_walk_mcap(const home::Home& home, home::RecordingId walk,
                                  const std::filesystem::path& path, double voxel_size_m,
                                  RunContext& run) {
  ROOMWISE_TRY(McapFileWriter writer, McapFileWriter::create(path));
  ROOMWISE_TRY(const WalkToWrite one, walk_to_write(home, walk, run));
  WalkLog log;
  log.keyframes_apart = one.walk().keyframes.size() - one.keyframes.size();
  const Channels channels = Channels::add_to(writer);
  ROOMWISE_CHECK_OK(write_home(one, voxel_size_m, channels, writer, log, run));
  ROOMWISE_CHECK_OK(write_pictures(one, channels, writer, log, run));
  ROOMWISE_CHECK_OK(
      write_poses_until(one.trajectory_world.back().timestamp_ns, one, channels, writer, log));
  ROOMWISE_CHECK_OK(writer.finish());
  return log;
}

}  // namespace roomwise::pipeline
