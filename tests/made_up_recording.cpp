#include "made_up_recording.h"

#include <cmath>

#include "roomwise/base/random.h"
#include "roomwise/recording/trajectory_file.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::testing {
namespace {

constexpr double kWallDistance_m = 2.0;
constexpr int kPatternCell_px = 6;
constexpr TimestampNs kFramePeriod_ns = 100'000'000;

geometry::PinholeCamera made_up_camera() {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = 300;
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.width = 320;
  camera.height = 240;
  return camera;
}

// How far the wall has moved through the picture in the n-th frame, whole pixels.
struct Shift {
  int x = 0;
  int y = 0;
};
Shift shift_at(int frame) {
  return {3 * frame, static_cast<int>(std::lround(20 * std::sin(0.2 * frame)))};
}

// The wall's brightness is the same wherever it is seen from.
std::uint8_t wall_at(int x, int y) {
  const auto cell = [](int v) { return static_cast<std::uint64_t>(v / kPatternCell_px + 1000); };
  return static_cast<std::uint8_t>(RandomStream(1, {cell(x), cell(y)}).index(256));
}

// The hall's light is warm, the kitchen's cold.
Rgb8 lit(std::uint8_t gray, bool is_hall) {
  const auto dimmed = static_cast<std::uint8_t>(gray * 3 / 4);
  return is_hall ? Rgb8{gray, gray, dimmed} : Rgb8{dimmed, gray, gray};
}

image::ColorImage picture_of_wall(const geometry::PinholeCamera& camera, Shift shift,
                                  bool is_hall) {
  image::ColorImage picture(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      picture.at(x, y) = lit(wall_at(x + shift.x + 600, y + shift.y + 600), is_hall);
    }
  }
  return picture;
}

}  // namespace

Expected<void> write_made_up_recording(const std::filesystem::path& folder, int frames, int first) {
  const geometry::PinholeCamera camera = made_up_camera();
  ROOMWISE_TRY(const auto writer, recording::TumWriter::create(folder, camera));
  recording::Trajectory truth;
  const auto depth = static_cast<std::uint16_t>(kWallDistance_m * camera.depth_units_per_metre);
  for (int i = 0; i < frames; ++i) {
    const Shift shift = shift_at(first + i);
    image::RgbdFrame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.timestamp_ns = (i + 1) * kFramePeriod_ns;
    const bool is_hall = i < frames / 2;
    frame.color = picture_of_wall(camera, shift, is_hall);
    frame.depth = image::DepthImage(camera.width, camera.height, depth);
    ROOMWISE_RETURN_IF_ERROR(writer->name_room(is_hall ? "hall" : "kitchen"));
    ROOMWISE_RETURN_IF_ERROR(writer->write(frame));
    const Eigen::Vector3d place(shift.x * kWallDistance_m / camera.fx,
                                shift.y * kWallDistance_m / camera.fy, 0);
    truth.push_back({frame.timestamp_ns, {Eigen::Quaterniond::Identity(), place}});
  }
  ROOMWISE_RETURN_IF_ERROR(writer->close());
  return recording::write_trajectory(folder / "groundtruth.txt", truth);
}

}  // namespace roomwise::testing
