#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/recognition/room_gallery.h"

namespace roomwise::rooms {

// Turns similarities into probabilities, and says from where on an answer is given. All of it is
// found from pictures that were held out while learning.
struct RoomCalibration {
  // Probabilities are a softmax of the rooms' similarities divided by this (temperature scaling,
  // Guo et al. 2017): under it, held-out pictures' true rooms are the most probable.
  double temperature = 0.06;
  // Mean and standard deviation of the similarities of held-out pictures.
  double whitened_cosine_mean = 0.4;
  double whitened_cosine_deviation = 0.1;
  double plain_cosine_mean = 0.9;
  double plain_cosine_deviation = 0.03;
  // Of each room: the mean familiarity, before it is subtracted, of the held-out pictures most
  // similar to it, with five average ones beside them. A hall of bare walls is more familiar than a
  // kitchen, and so is the hall of another home. Empty: nothing is subtracted.
  std::vector<double> room_familiarity_means = {};
  // A room is named from this probability on: above it held-out pictures were named rightly as
  // often as is asked (kMinPrecision).
  double confidence_threshold = 0.8;
  // ... if the picture is as familiar as this; 5 % of the held-out pictures were not.
  double acceptance_threshold = -1.65;
  // Less familiar than this: none of the rooms; 1 % of the held-out pictures were.
  double reject_threshold = -2.3;

  static constexpr double kMinPrecision = 0.97;

  // Each room's probability, every room alike beforehand.
  [[nodiscard]] Eigen::VectorXd probabilities(const Similarity& similarity) const;
  // The mean of a picture's whitened and plain cosine similarity, in deviations of the held-out
  // pictures, less the mean of the room that it is most similar to: 0 is as usual there, or, in a
  // room of few pictures, between that and the mean of all.
  [[nodiscard]] double familiarity(const Similarity& similarity) const;

  // Fails, naming the field, on what is not finite or out of range.
  [[nodiscard]] Expected<void> validate() const;

  friend bool operator==(const RoomCalibration&, const RoomCalibration&) = default;
};

// A picture that was compared while it was held out, and its room.
struct HeldOutPicture {
  Similarity similarity;
  int room = 0;
};

// At least one picture.
[[nodiscard]] RoomCalibration calibrate(std::span<const HeldOutPicture> held_out);

}  // namespace roomwise::rooms
