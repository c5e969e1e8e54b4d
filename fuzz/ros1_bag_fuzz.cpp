// Any bytes as a ROS 1 bag.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/robot/robot_recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_recording(data, size, roomwise::recording::open_ros1_bag_recording);
  return 0;
}
