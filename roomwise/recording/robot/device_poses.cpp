#include "roomwise/recording/robot/device_poses.h"

#include <algorithm>

#include "roomwise/recording/inertial_file.h"
#include "roomwise/recording/robot/streams.h"

namespace roomwise::recording {
namespace {

// RealSense writes into ".../tf/0" where its stream lies seen from a common point of reference.
std::optional<TransformMessage> realsense_transform(const Channel& channel, const Bytes& bytes) {
  const std::string stream = realsense_stream_of(channel.topic);
  const std::size_t at = channel.topic.find("/tf/");
  if (stream.empty() || at == std::string::npos) return std::nullopt;
  const auto stream_from_reference = decode_bare_transform(channel, bytes);
  if (!stream_from_reference) return std::nullopt;
  const std::string device = stream.substr(0, stream.find('/', 1));
  TransformMessage transform;
  transform.header.frame = fmt::format("{}/reference_{}", device, channel.topic.substr(at + 4));
  transform.child = stream;
  transform.parent_from_child = stream_from_reference->inverse();
  return transform;
}

// False where the message cannot be read.
bool add_transforms(const Channel& channel, const Bytes& bytes, TransformTree& tree) {
  if (channel.type == MessageType::kBareTransform) {
    const auto transform = realsense_transform(channel, bytes);
    if (transform) tree.add(*transform);
    return true;
  }
  const auto transforms = decode_transforms(channel, bytes);
  if (!transforms) return false;
  for (const TransformMessage& transform : *transforms) tree.add(transform);
  return true;
}

bool is_transform(const Channel& channel) {
  return channel.type == MessageType::kTransforms || channel.type == MessageType::kTransform ||
         channel.type == MessageType::kBareTransform;
}

struct Odometry {
  std::string child;
  MovingTransform world_from_child;
};

Expected<TransformMessage> read_pose(const MessageLog& log, std::size_t channel,
                                     const MessagePlace& message) {
  ROOMWISE_TRY(const Bytes bytes, log.read(message));
  return decode_odometry(log.channels()[channel], bytes);
}

Odometry read_odometry(const MessageLog& log, std::size_t channel) {
  Odometry odometry;
  for (const MessagePlace& message : log.messages(channel)) {
    const auto pose = read_pose(log, channel, message);
    if (!pose) continue;
    odometry.child = pose->child;
    odometry.world_from_child.add(message.timestamp_ns, pose->parent_from_child);
  }
  odometry.world_from_child.sort();
  return odometry;
}

// Whether odometry says where the camera goes and transforms do not: those that move the camera
// move it within the robot alone, whose place in the odometry's frame they leave open.
bool is_needed(const TransformMessage& odometry, const TransformTree& tree,
               const std::string& camera_frame) {
  const std::string root = tree.root_of(camera_frame);
  if (tree.root_of(odometry.child) != root) return false;
  return !tree.moves(camera_frame, root) ||
         (!tree.moves(odometry.child, root) && tree.root_of(odometry.header.frame) != root);
}

// Those with most messages first.
std::vector<std::size_t> needed_odometry(const MessageLog& log, const TransformTree& tree,
                                         const std::string& camera_frame) {
  std::vector<std::size_t> channels;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    if (log.channels()[i].type != MessageType::kOdometry) continue;
    for (const MessagePlace& message : log.messages(i)) {
      const auto pose = read_pose(log, i, message);
      if (!pose) continue;
      if (is_needed(*pose, tree, camera_frame)) channels.push_back(i);
      break;
    }
  }
  std::ranges::stable_sort(channels, std::greater<>(),
                           [&](std::size_t i) { return log.messages(i).size(); });
  return channels;
}

Trajectory poses_by(const Odometry& odometry, const TransformTree& tree,
                    const std::string& camera_frame, const std::vector<TimestampNs>& times) {
  Trajectory poses;
  for (const TimestampNs time : times) {
    const auto world_from_child = odometry.world_from_child.at(time);
    const auto child_from_camera = tree.look_up(odometry.child, camera_frame, time);
    if (!world_from_child || !child_from_camera) continue;
    poses.push_back({time, *world_from_child * *child_from_camera});
  }
  return poses;
}

}  // namespace

TransformTree read_transforms(const MessageLog& log, std::vector<std::string>& notes) {
  TransformTree tree;
  std::size_t unread = 0;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    const Channel& channel = log.channels()[i];
    if (!is_transform(channel)) continue;
    for (const MessagePlace& message : log.messages(i)) {
      const auto bytes = log.read(message);
      if (!bytes || !add_transforms(channel, *bytes, tree)) ++unread;
    }
  }
  if (unread > 0) notes.push_back(fmt::format("{} messages of transforms cannot be read", unread));
  tree.sort();
  return tree;
}

DevicePoses find_device_poses(const MessageLog& log, const TransformTree& tree,
                              const std::string& camera_frame,
                              const std::vector<TimestampNs>& times) {
  DevicePoses found;
  const auto channels = needed_odometry(log, tree, camera_frame);
  for (const std::size_t channel : channels) {
    found.poses = poses_by(read_odometry(log, channel), tree, camera_frame, times);
    if (!found.poses.empty()) break;
  }
  const std::string world = tree.root_of(camera_frame);
  if (!channels.empty() || !tree.moves(camera_frame, world)) return found;
  found.are_odometry = world.find("odom") != std::string::npos;
  for (const TimestampNs time : times) {
    const auto world_from_camera = tree.look_up(world, camera_frame, time);
    if (world_from_camera) found.poses.push_back({time, *world_from_camera});
  }
  return found;
}

geometry::InertialTrack find_inertial(const MessageLog& log, const TransformTree& tree,
                                      const std::string& camera_frame,
                                      std::vector<std::string>& notes) {
  std::optional<std::size_t> channel;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    if (log.channels()[i].type != MessageType::kInertial) continue;
    if (!channel || log.messages(i).size() > log.messages(*channel).size()) channel = i;
  }
  if (!channel || log.messages(*channel).empty()) return {};
  const std::string& topic = log.channels()[*channel].topic;
  InertialSamples samples(topic, /*tells_turns=*/true);
  // Where a transform is known at any time, only what one turns is in the camera's frame.
  const auto look_up = [&](const std::string& frame, TimestampNs at) {
    return tree.look_up(camera_frame, frame, at);
  };
  bool is_connected = false;
  for (const MessagePlace& place : log.messages(*channel)) {
    const auto message = log.read(place).and_then(
        [&](const Bytes& bytes) { return decode_inertial(log.channels()[*channel], bytes); });
    is_connected = message && look_up(message->header.frame, message->sample.timestamp_ns);
    if (is_connected) break;
  }
  for (const MessagePlace& place : log.messages(*channel)) {
    const std::string when = format_timestamp(place.timestamp_ns) + " s";
    auto message = log.read(place).and_then(
        [&](const Bytes& bytes) { return decode_inertial(log.channels()[*channel], bytes); });
    if (!message) {
      samples.leave_out(when + ": " + message.error().message);
      continue;
    }
    geometry::InertialSample& sample = message->sample;
    const auto camera_from_imu = look_up(message->header.frame, sample.timestamp_ns);
    if (is_connected && !camera_from_imu) {
      samples.leave_out(when + ": no transform says how the sensor is turned to the camera");
      continue;
    }
    if (camera_from_imu) {
      sample.turning_rad_s = camera_from_imu->rotation * sample.turning_rad_s;
      sample.force_m_s2 = camera_from_imu->rotation * sample.force_m_s2;
    }
    samples.add(sample, when);
  }
  if (!is_connected) {
    notes.push_back(fmt::format(
        "{}: no transform says how the sensor is turned to the camera: it is taken as not turned",
        topic));
  }
  return std::move(samples).finish(notes);
}

}  // namespace roomwise::recording
