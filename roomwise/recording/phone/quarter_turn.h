#pragma once

#include <algorithm>
#include <optional>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/image.h"
#include "roomwise/recording/trajectory_file.h"

// A phone's sensor lies across it: pictures of who holds it upright lie on their side. They are
// turned by the poses, which know where up is, since networks know things that stand. `turns`: by
// so many quarters to the right, 0 to 3.
namespace roomwise::recording {

// What turns most of the pictures upright. Those that look at the floor or the ceiling do not
// count; absent where all do. `device_up` as of RecordingContents.
[[nodiscard]] std::optional<int> upright_turns(const Trajectory& world_from_camera,
                                               const Eigen::Vector3d& device_up);

// The camera whose pictures are the turned ones of a camera without lens distortion.
[[nodiscard]] geometry::PinholeCamera turned(const geometry::PinholeCamera& camera, int turns);
// Points of the camera frame in that of the turned camera.
[[nodiscard]] geometry::RigidTransform turned_from_camera(int turns);

template <typename Pixel>
[[nodiscard]] image::Image<Pixel> turned(image::Image<Pixel> picture, int turns) {
  if (turns == 0) return picture;
  if (turns == 2) {
    std::ranges::reverse(picture.pixels());
    return picture;
  }
  image::Image<Pixel> other(picture.height(), picture.width());
  for (int y = 0; y < other.height(); ++y) {
    for (int x = 0; x < other.width(); ++x) {
      other.at(x, y) = turns == 1 ? picture.at(y, picture.height() - 1 - x)
                                  : picture.at(picture.width() - 1 - y, x);
    }
  }
  return other;
}

}  // namespace roomwise::recording
