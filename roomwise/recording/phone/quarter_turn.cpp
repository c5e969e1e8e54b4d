#include "roomwise/recording/phone/quarter_turn.h"

#include <array>
#include <cmath>
#include <numbers>

namespace roomwise::recording {

std::optional<int> upright_turns(const Trajectory& world_from_camera,
                                 const Eigen::Vector3d& device_up) {
  std::array<int, 4> pictures{};
  for (const StampedPose& pose : world_from_camera) {
    const Eigen::Vector2d up = (pose.world_from_camera.rotation.conjugate() * device_up).head<2>();
    if (up.norm() < 0.5) continue;  // less than 30 degrees from straight down or up
    // Up is -y in a picture that stands: from there it goes round to the left.
    const double to_left = std::atan2(-up.x(), -up.y());
    const auto quarters = static_cast<int>(std::lround(to_left / (std::numbers::pi / 2)));
    ++pictures.at(static_cast<std::size_t>((quarters + 4) % 4));
  }
  const auto most = std::ranges::max_element(pictures);
  if (*most == 0) return std::nullopt;
  return static_cast<int>(most - pictures.begin());
}

geometry::PinholeCamera turned(const geometry::PinholeCamera& camera, int turns) {
  geometry::PinholeCamera other = camera;
  for (int i = 0; i < turns; ++i) {
    const geometry::PinholeCamera before = other;
    other.width = before.height;
    other.height = before.width;
    other.fx = before.fy;
    other.fy = before.fx;
    other.cx = before.height - 1 - before.cy;
    other.cy = before.cx;
  }
  return other;
}

geometry::RigidTransform turned_from_camera(int turns) {
  const Eigen::AngleAxisd turn(turns * std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
  return {Eigen::Quaterniond(turn), Eigen::Vector3d::Zero()};
}

}  // namespace roomwise::recording
