#pragma once

#include <Eigen/Core>
#include <optional>

#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/random.h"
#include "roomwise/guide/places/places.h"

namespace roomwise::trials {

// How the localiser answers, as it was measured (docs/experiments/localizer-fitted.md), without
// drawing a picture: whether it answers comes in stretches, since what it cannot place (a bare
// wall) fills more than one picture.
struct PositionModel {
  double pictures_per_s = 2;
  double latency_s = 0.3;          // from picture to pose
  double answered_share = 0.88;    // of pictures
  double stretch_s = 1.5;          // mean length of a stretch, answered or not
  double sigma_m = 0.03;           // of the position, along each direction
  double sigma_degrees = 1;        // of the heading
  double wrong_share = 0.003;      // of answers: anywhere within a few metres
  double room_known_share = 0.98;  // where the pose is not known, of pictures
  bool has_depth = false;          // the camera measures what stands ahead

  // Of a phone without calibration, by what has changed since the map was made.
  [[nodiscard]] static PositionModel of(simulation::Scenario scenario);
  [[nodiscard]] Expected<void> validate() const;
};

// The poses that come of it, one walk long.
class ModelledPosition {
 public:
  ModelledPosition(const PositionModel& model, std::uint64_t seed)
      : model_(model), random_(seed, {0x706f7365}) {}

  struct Answer {
    std::optional<guide::Pose> pose;
    double at_s = 0;  // when the picture was taken
    // Where it was taken, in truth.
    Eigen::Vector2d true_place = Eigen::Vector2d::Zero();
    double true_heading_rad = 0;
    bool knows_room = false;
  };
  // Of the picture that was taken latency_s ago, if one was.
  [[nodiscard]] std::optional<Answer> look(double now_s, const Eigen::Vector2d& place,
                                           double heading_rad);

 private:
  PositionModel model_;
  RandomStream random_;
  double next_picture_s_ = 0;
  bool answers_ = true;
  double changes_at_s_ = 0;
  std::optional<Answer> pending_;
};

}  // namespace roomwise::trials
