#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/recording/messages/message_log.h"
#include "roomwise/recording/robot/pixels.h"
#include "roomwise/recording/robot/transform_tree.h"

namespace roomwise::recording {

// A channel of images, as its first message shows it.
struct ImageStream {
  std::size_t channel = 0;  // in the log
  std::string topic;
  PixelKind kind = PixelKind::kOther;
  bool is_compressed = false;
  std::string frame;  // of coordinates
  int width = 0, height = 0;
  std::size_t count = 0;                          // messages
  TimestampNs first_ns = 0;                       // time of the first one
  std::optional<geometry::PinholeCamera> camera;  // absent: no camera info belongs to it
  std::string no_camera_reason;
  double depth_unit_m = 0.001;  // of a depth stream of whole numbers
};

// The image channels of a log, with their cameras. To a picture belongs a camera info of its size
// whose namespace holds its topic, or whose frame is its own: the closest namespace, then the
// frame, then the name that is most alike. A channel of which no message can be read is left
// out, and `notes` says why. One of several sizes has that of most of its first messages.
[[nodiscard]] std::vector<ImageStream> find_image_streams(const MessageLog& log,
                                                          std::vector<std::string>& notes);

// How depth gets into the colour picture.
struct StreamPair {
  ImageStream color, depth;
  bool is_registered = false;                 // the depth image lies on the colour picture already
  geometry::RigidTransform color_from_depth;  // where it does not
};

// The colour and the depth stream to read. Of all that fit together: colour before grey, depth that
// is registered already before other depth, cameras that are closer together, more pictures, whole
// images before compressed ones, and the topics' names. `notes` names the other image topics. Fails
// where none fit, naming what is there and why it does not fit.
[[nodiscard]] Expected<StreamPair> choose_streams(const std::vector<ImageStream>& streams,
                                                  const TransformTree& tree,
                                                  std::vector<std::string>& notes);

// RealSense's own recorder writes no frames of coordinates; its streams are told apart by the first
// parts of their topics ("/device_0/sensor_0/Depth_0"). Empty for other topics.
[[nodiscard]] std::string realsense_stream_of(const std::string& topic);

}  // namespace roomwise::recording
