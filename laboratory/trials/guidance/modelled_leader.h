#pragma once

#include "laboratory/trials/guidance/leader.h"
#include "laboratory/trials/guidance/modelled_position.h"

namespace roomwise::trials {

// What modelled pictures tell of where somebody is.
class ModelledSight {
 public:
  ModelledSight(const WalkedHome& home, const PositionModel& model, std::uint64_t seed)
      : home_(home), has_depth_(model.has_depth), position_(model, seed) {}

  void look(double now_s, const SimulatedWalker& walker);
  // As a guide is told now.
  [[nodiscard]] guide::Walker at(double now_s) const;
  [[nodiscard]] const std::optional<guide::Pose>& pose() const { return state_.pose; }
  [[nodiscard]] double pose_age_s(double now_s) const { return now_s - pose_s_; }
  [[nodiscard]] const Sightings& sightings() const { return sightings_; }

 private:
  const WalkedHome& home_;
  bool has_depth_;
  ModelledPosition position_;
  guide::Walker state_;
  double pose_s_ = 0;
  Sightings sightings_;
};

// The guide itself, on the home's true map and by modelled places.
class ModelledLeader final : public Leader {
 public:
  ModelledLeader(const guide::HomeMap& map, guide::Goal goal, const guide::Wording& wording,
                 const guide::GuidanceOptions& options, ModelledSight& sight)
      : guidance_(map, std::move(goal), wording, options), sight_(sight) {}

  [[nodiscard]] Expected<std::vector<guide::Prompt>> after_step(
      double now_s, const SimulatedWalker& walker) override;
  [[nodiscard]] Expected<std::vector<guide::Prompt>> request(guide::GuidanceRequest request,
                                                             double now_s) override {
    return std::vector{guidance_.request(request, trial_ns(now_s))};
  }
  [[nodiscard]] bool knows_goal() const override { return true; }
  [[nodiscard]] bool is_over() const override { return guidance_.is_over(); }
  [[nodiscard]] bool says_there() const override {
    return guidance_.state() == guide::Guidance::State::kArrived;
  }
  [[nodiscard]] std::optional<Eigen::Vector2d> next_place(const SimulatedWalker&) const override {
    return guidance_.next_place();
  }
  [[nodiscard]] const Sightings& sightings() const override { return sight_.sightings(); }

 private:
  guide::Guidance guidance_;
  ModelledSight& sight_;
  double next_update_s_ = 0;
};

}  // namespace roomwise::trials
