#include "laboratory/trials/guidance/modelled_position.h"

#include <cmath>
#include <utility>

#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {

using simulation::Scenario;

PositionModel PositionModel::of(Scenario scenario) {
  PositionModel model;
  switch (scenario) {
    case Scenario::kDay:
      break;
    case Scenario::kEvening:
      model.answered_share = 0.69;
      break;
    case Scenario::kNight:
    case Scenario::kMovedNight:
      model.answered_share = 0.46;
      model.wrong_share = 0.004;
      break;
    case Scenario::kMoved:
      model.answered_share = 0.74;
      model.wrong_share = 0.005;
      break;
  }
  return model;
}

Expected<void> PositionModel::validate() const {
  if (!(pictures_per_s > 0 && latency_s >= 0 && stretch_s > 0)) {
    return fail("pictures_per_s is {}, latency_s {} and stretch_s {}; expected more than 0",
                pictures_per_s, latency_s, stretch_s);
  }
  if (!(answered_share > 0 && answered_share <= 1 && wrong_share >= 0 && wrong_share < 1)) {
    return fail("answered_share is {} and wrong_share {}; expected shares", answered_share,
                wrong_share);
  }
  if (!(sigma_m > 0 && sigma_degrees >= 0)) {
    return fail("sigma_m is {} and sigma_degrees {}; expected more than 0, and 0 or more", sigma_m,
                sigma_degrees);
  }
  return {};
}

std::optional<ModelledPosition::Answer> ModelledPosition::look(double now_s,
                                                               const Eigen::Vector2d& place,
                                                               double heading_rad) {
  std::optional<Answer> ready;
  if (pending_ && now_s >= pending_->at_s + model_.latency_s) {
    ready = std::move(pending_);
    pending_.reset();
  }
  if (now_s < next_picture_s_) return ready;
  next_picture_s_ = now_s + 1 / model_.pictures_per_s;
  if (now_s >= changes_at_s_) {
    // Stretches of exponential length, each answered or silent.
    answers_ = random_.uniform() < model_.answered_share;
    changes_at_s_ = now_s - model_.stretch_s * std::log(1 - random_.uniform());
  }
  Answer answer{std::nullopt, now_s, place, heading_rad,
                random_.uniform() < model_.room_known_share};
  if (answers_) {
    guide::Pose pose{place, heading_rad, model_.sigma_m};
    pose.position_plan += model_.sigma_m * Eigen::Vector2d(random_.normal(), random_.normal());
    pose.heading_rad += model_.sigma_degrees * guide::kDegree_rad * random_.normal();
    if (random_.uniform() < model_.wrong_share) {
      constexpr double kFar_m = 4;
      pose.position_plan +=
          Eigen::Vector2d(random_.between(-kFar_m, kFar_m), random_.between(-kFar_m, kFar_m));
      pose.heading_rad += random_.between(-3, 3);
    }
    answer.pose = pose;
  }
  pending_ = answer;
  return ready;
}

}  // namespace roomwise::trials
