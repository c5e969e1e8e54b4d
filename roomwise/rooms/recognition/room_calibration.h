#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/recognition/room_gallery.h"

namespace roomwise::rooms {

// What similarities mean in a home: found from pictures that were held out while learning.
struct RoomCalibration {
  // Probabilities are a softmax of the rooms' similarities divided by this (temperature scaling,
  // Guo et al. 2017): under it, held-out pictures' true rooms are the most probable.
  double temperature = 0.06;
  // Mean and standard deviation of the similarities of held-out pictures.
  double whitened_cosine_mean = 0.4;
  double whitened_cosine_deviation = 0.1;
  double plain_cosine_mean = 0.9;
  double plain_cosine_deviation = 0.03;

  // Each room's probability by similarity alone, every room alike beforehand.
  [[nodiscard]] Eigen::VectorXd probabilities(const Similarity& similarity) const;
  // The mean of both cosines, in deviations of the held-out pictures: 0 is as similar as they are.
  [[nodiscard]] double deviations(const Similarity& similarity) const;

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
