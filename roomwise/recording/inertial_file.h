#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/inertial_track.h"

namespace roomwise::recording {

// Takes what an inertial sensor wrote, sample after sample, and makes of it what can be used. A
// walk does not fail by it: what is wrong is left out, and a note says so in a line.
class InertialSamples {
 public:
  // `name`, for people: the file or topic.
  InertialSamples(std::string name, bool tells_turns)
      : name_(std::move(name)), tells_turns_(tells_turns) {}

  // In the camera's frame. `place`, for people: the line or message. A sample with a number that is
  // not finite, or whose time is not later than the one before, is left out.
  void add(const geometry::InertialSample& sample, const std::string& place);
  void leave_out(const std::string& why);
  // Forces in g, as the median length tells, become m/s^2. Nothing is left of forces whose median
  // is no gravity, nor turns of more than sensors measure.
  [[nodiscard]] geometry::InertialTrack finish(std::vector<std::string>& notes) &&;

 private:
  std::string name_;
  bool tells_turns_;
  std::vector<geometry::InertialSample> samples_;
  std::size_t left_out_ = 0;
  std::string why_;  // the first was
};

// What an inertial sensor wrote into a TUM folder; empty where it wrote nothing, or nothing that
// can be used, which is noted.
//
// imu.txt: a line a sample, "timestamp wx wy wz ax ay az" (s, rad/s, m/s^2, the specific force: at
// rest 9.8 upwards), '#' begins a comment. In the camera's frame (x right, y down, z forward), or
// in the sensor's where a comment "# camera_from_imu qx qy qz qw" says how it is turned.
//
// accelerometer.txt, where there is no imu.txt: "timestamp ax ay az" of TUM's own recordings. The
// Kinect's axes are the camera's, turned by half a turn about z (within 0.06 rad by the truth of
// fr1/rpy).
[[nodiscard]] geometry::InertialTrack read_inertial(const std::filesystem::path& folder,
                                                    std::vector<std::string>& notes);
// Writes the one of the two that fits; `what`, one line, says for people of what it is.
[[nodiscard]] Expected<void> write_inertial(const std::filesystem::path& folder,
                                            const geometry::InertialTrack& track,
                                            std::string_view what);

}  // namespace roomwise::recording
