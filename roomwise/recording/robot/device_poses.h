#pragma once

#include "roomwise/recording/messages/message_log.h"
#include "roomwise/recording/robot/transform_tree.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::recording {

// All transforms between frames that the log holds, RealSense's extrinsics among them. Messages
// that cannot be read are left out, and `notes` says how many.
[[nodiscard]] TransformTree read_transforms(const MessageLog& log, std::vector<std::string>& notes);

struct DevicePoses {
  Trajectory poses;
  // The device's own odometry: messages of odometry, or transforms whose root says so by its name
  // ("odom"). Transforms from "map" or "world" were corrected by a map or measured from outside.
  bool are_odometry = true;
};

// Where the camera's frame was at these times (increasing), as far as it is known: in the frame
// above all others, where the camera moves in it; else by the odometry with most messages whose
// child is connected with the camera. Odometry comes first where transforms move the camera within
// the robot alone: none moves the child, nor connects the odometry's own frame with it.
[[nodiscard]] DevicePoses find_device_poses(const MessageLog& log, const TransformTree& tree,
                                            const std::string& camera_frame,
                                            const std::vector<TimestampNs>& times);

// What the inertial sensor with most messages felt, in the camera's frame by the transforms; where
// they do not connect the two, as if it were not turned to the camera, which is noted. Empty where
// there is none.
[[nodiscard]] geometry::InertialTrack find_inertial(const MessageLog& log,
                                                    const TransformTree& tree,
                                                    const std::string& camera_frame,
                                                    std::vector<std::string>& notes);

}  // namespace roomwise::recording
