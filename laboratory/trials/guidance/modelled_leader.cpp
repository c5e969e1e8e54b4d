#include "laboratory/trials/guidance/modelled_leader.h"

#include <Eigen/Geometry>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

// What a depth camera at the chest sees of what a body runs into: the nearest along each ray.
std::vector<Eigen::Vector2d> seen_by_depth(const fusion::FloorGrid& floor, const guide::Pose& eye) {
  constexpr int kHalfView_degrees = 28, kStep_degrees = 2;
  constexpr double kNearest_m = 0.4, kFarthest_m = 2, kStep_m = 0.05;
  std::vector<Eigen::Vector2d> seen;
  for (int degrees = -kHalfView_degrees; degrees <= kHalfView_degrees; degrees += kStep_degrees) {
    const Eigen::Rotation2Dd aside(degrees * guide::kDegree_rad);
    for (double along_m = kStep_m; along_m < kFarthest_m; along_m += kStep_m) {
      const Eigen::Vector2d place = aside * Eigen::Vector2d(along_m, 0);
      if (floor.at(eye.place_of(place)) == fusion::FloorCell::kFree) continue;
      if (along_m >= kNearest_m) seen.push_back(place);
      break;
    }
  }
  return seen;
}

}  // namespace

void ModelledSight::look(double now_s, const SimulatedWalker& walker) {
  const auto answer = position_.look(now_s, walker.place(), walker.heading_rad());
  if (!answer) return;
  ++sightings_.pictures;
  state_.room.reset();
  if (answer->knows_room) {
    state_.room = home_.model.rooms[simulation::room_at(home_.model, walker.place())].name;
  }
  if (!answer->pose) return;
  state_.pose = answer->pose;
  state_.has_depth = has_depth_;
  state_.obstacles.clear();
  if (has_depth_) {
    const guide::Pose eye{answer->true_place, answer->true_heading_rad};
    for (const Eigen::Vector2d& one : seen_by_depth(home_.floor, eye)) {
      state_.obstacles.push_back(answer->pose->place_of(one));
    }
  }
  pose_s_ = answer->at_s;
  sightings_.add(answer->pose->position_plan - answer->true_place,
                 guide::turn_rad(answer->true_heading_rad, answer->pose->heading_rad));
}

guide::Walker ModelledSight::at(double now_s) const {
  guide::Walker walker = state_;
  walker.now_ns = trial_ns(now_s);
  walker.pose_ns = trial_ns(pose_s_);
  return walker;
}

Expected<std::vector<guide::Prompt>> ModelledLeader::after_step(double now_s,
                                                                const SimulatedWalker& walker) {
  constexpr double kUpdate_s = 0.2;
  sight_.look(now_s, walker);
  if (now_s < next_update_s_) return std::vector<guide::Prompt>();
  next_update_s_ = now_s + kUpdate_s;
  auto prompt = guidance_.update(sight_.at(now_s));
  return prompt ? std::vector{*std::move(prompt)} : std::vector<guide::Prompt>();
}

}  // namespace roomwise::trials
