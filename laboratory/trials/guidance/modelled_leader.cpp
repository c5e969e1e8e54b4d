#include "laboratory/trials/guidance/modelled_leader.h"

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/guide/legs.h"

namespace roomwise::trials {

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
  pose_s_ = answer->at_s;
  sightings_.add(answer->pose->position_gravity - answer->true_place,
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
