#include "roomwise/recording/robot/device_poses.h"

#include <algorithm>

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

Odometry read_odometry(const MessageLog& log, std::size_t channel) {
  Odometry odometry;
  for (const MessagePlace& message : log.messages(channel)) {
    const auto bytes = log.read(message);
    const auto pose = bytes ? decode_odometry(log.channels()[channel], *bytes)
                            : Expected<TransformMessage>(Unexpected(bytes.error()));
    if (!pose) continue;
    odometry.child = pose->child;
    odometry.world_from_child.add(message.timestamp_ns, pose->parent_from_child);
  }
  odometry.world_from_child.sort();
  return odometry;
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

Trajectory poses_by_odometry(const MessageLog& log, const TransformTree& tree,
                             const std::string& camera_frame,
                             const std::vector<TimestampNs>& times) {
  std::vector<std::size_t> channels;
  for (std::size_t i = 0; i < log.channels().size(); ++i) {
    if (log.channels()[i].type == MessageType::kOdometry) channels.push_back(i);
  }
  std::ranges::stable_sort(channels, std::greater<>(),
                           [&](std::size_t i) { return log.messages(i).size(); });
  for (const std::size_t channel : channels) {
    Trajectory poses = poses_by(read_odometry(log, channel), tree, camera_frame, times);
    if (!poses.empty()) return poses;
  }
  return {};
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

bool are_odometry(const TransformTree& tree, const std::string& camera_frame) {
  const std::string world = tree.root_of(camera_frame);
  return !tree.moves(camera_frame, world) || world.find("odom") != std::string::npos;
}

Trajectory find_device_poses(const MessageLog& log, const TransformTree& tree,
                             const std::string& camera_frame,
                             const std::vector<TimestampNs>& times) {
  const std::string world = tree.root_of(camera_frame);
  if (!tree.moves(camera_frame, world)) return poses_by_odometry(log, tree, camera_frame, times);
  Trajectory poses;
  for (const TimestampNs time : times) {
    const auto world_from_camera = tree.look_up(world, camera_frame, time);
    if (world_from_camera) poses.push_back({time, *world_from_camera});
  }
  return poses;
}

}  // namespace roomwise::recording
