#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/recognition/room_calibration.h"

namespace roomwise::rooms {

// What tells whether a picture shows one of the learned rooms at all.
// The first three mean the same in every home that was learned with one network. The last two are
// logarithms of how many times farther than held-out pictures it is, whatever the network.
constexpr std::size_t kFamiliarityNumbers = 5;
constexpr std::array<std::string_view, kFamiliarityNumbers> kFamiliarityNames = {
    "plain cosine", "whitened cosine", "usual whitened cosine", "relative plain distance",
    "relative whitened distance"};
using FamiliarityNumbers = std::array<double, kFamiliarityNumbers>;
[[nodiscard]] FamiliarityNumbers familiarity_numbers(const Similarity& similarity,
                                                     const RoomCalibration& calibration);

// What the opinion pool weighs, a row a room: the logarithm of the similarities' softmax, up to a
// number that is the same for all, and that of the regression's probability.
[[nodiscard]] Eigen::MatrixX2d pooled_opinions(const Similarity& similarity,
                                               const Eigen::VectorXd& regression,
                                               const RoomCalibration& calibration);

// What the decision about rooms is made with, the same for every home that was learned with a
// network. Its numbers are those of room_model.json, which roomwise-lab fit-rooms writes; where
// they come from stands there.
struct RoomModel {
  std::string network;  // how its name begins; empty: any
  // P(room | one of these rooms) is a softmax of the logarithm of the similarities' softmax
  // (RoomCalibration) times the first and of the regression's, the paper's way, times the second: a
  // logarithmic opinion pool.
  double similarity_weight = 1;
  double regression_weight = 1;
  // Logistic regression of whether a picture shows one of the learned rooms.
  double bias = 0;
  FamiliarityNumbers weights{};
  // A room is named, or one of two, from this probability on that it is right.
  double min_probability = 0.9;
  // Below these log odds of the learned rooms: none of them.
  double reject_log_odds = -3;

  // Each room's probability, every room alike beforehand, if it is one of them. regression: the
  // paper's probability of each.
  [[nodiscard]] Eigen::VectorXd probabilities(const Similarity& similarity,
                                              const Eigen::VectorXd& regression,
                                              const RoomCalibration& calibration) const;
  // The log odds that a picture shows one of the learned rooms.
  [[nodiscard]] double familiarity(const FamiliarityNumbers& numbers) const;

  // That of room_model.json, which is compiled in, for a network of this name: what was fitted to
  // it, else to any network.
  [[nodiscard]] static const RoomModel& of(std::string_view network);
};
// Those of a file, the one for any network last. Fails, naming the field, where one is missing, of
// another type, not finite or out of range.
[[nodiscard]] Expected<std::vector<RoomModel>> parse_room_models(std::string_view json);

// The probability of log odds.
[[nodiscard]] double probability_of(double log_odds);

}  // namespace roomwise::rooms
