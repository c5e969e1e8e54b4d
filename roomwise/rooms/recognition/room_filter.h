#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/layout/room_topology.h"

namespace roomwise::rooms {

struct RoomFilterOptions {
  double mean_dwell_s = 10;  // in a room, before going on
  // For so long pictures that follow each other show the same and say the same: pictures that are
  // taken within it count together about as much as one.
  double correlation_time_s = 1.0;

  [[nodiscard]] Expected<void> validate() const;
};

// Believes in which room a person is who walks through a home and takes picture after picture: the
// forward algorithm of a hidden Markov model (Rabiner 1989) in continuous time. One stays in a room
// for some time and leaves it by its doors. However often pictures are taken, the same time passes:
// ten steps of 0.1 s move a belief as one of 1 s does.
class RoomFilter {
 public:
  // Begins anywhere, every room alike. Throws std::invalid_argument where options are not valid.
  explicit RoomFilter(const RoomTopology& topology, const RoomFilterOptions& options = {});

  // `elapsed_s` have passed; nothing was seen.
  void predict(double elapsed_s);
  // A picture is seen `elapsed_s` after the one before (the first counts fully, whatever it says).
  // `probabilities`: of each room, in the order of rooms(), by the picture alone with every room
  // alike beforehand. A picture that is all zeros says nothing.
  void update(std::span<const double> probabilities, double elapsed_s);

  // Of each room, in the order of rooms(); they add up to 1.
  [[nodiscard]] const Eigen::VectorXd& belief() const { return belief_; }
  [[nodiscard]] const std::vector<std::string>& rooms() const { return rooms_; }

 private:
  std::vector<std::string> rooms_;
  RoomFilterOptions options_;
  Eigen::MatrixXd rates_;  // of going from room (row) to room (column), 1/s; rows add up to 0
  Eigen::VectorXd belief_;
  bool has_seen_ = false;
};

}  // namespace roomwise::rooms
