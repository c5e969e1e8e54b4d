#include "laboratory/trials/guidance/true_frame.h"

#include <cmath>

#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

Eigen::Vector2d moved(const geometry::RigidTransform& to_from, const Eigen::Vector2d& place) {
  return (to_from * Eigen::Vector3d(place.x(), place.y(), 0)).head<2>();
}

double turned(const geometry::RigidTransform& to_from, double heading_rad) {
  const Eigen::Vector3d ahead =
      to_from.rotation * Eigen::Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0);
  return std::atan2(ahead.y(), ahead.x());
}

}  // namespace

Eigen::Vector2d TrueFrame::to_truth(const Eigen::Vector2d& place_gravity) const {
  return moved(truth_from_gravity, place_gravity);
}

Eigen::Vector2d TrueFrame::to_map(const Eigen::Vector2d& place_truth) const {
  return moved(truth_from_gravity.inverse(), place_truth);
}

double TrueFrame::heading_on_map(double heading_truth_rad) const {
  return turned(truth_from_gravity.inverse(), heading_truth_rad);
}

void add_error(const service::SeenPosition& told, const geometry::RigidTransform& truth_from_camera,
               const TrueFrame& frame, Sightings& sightings) {
  const Eigen::Vector3d axis = truth_from_camera.rotation * Eigen::Vector3d::UnitZ();
  const double told_heading_rad =
      turned(frame.truth_from_gravity, told.heading_degrees * guide::kDegree_rad);
  sightings.add(frame.to_truth({told.x_m, told.y_m}) - truth_from_camera.translation.head<2>(),
                guide::turn_rad(std::atan2(axis.y(), axis.x()), told_heading_rad));
}

}  // namespace roomwise::trials
