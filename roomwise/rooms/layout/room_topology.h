#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace roomwise::rooms {

// Which rooms doors lead between, as far as a walk shows it.
class RoomTopology {
 public:
  // No door is known: every room leads to every other alike.
  explicit RoomTopology(std::vector<std::string> rooms);
  // `walk`: the rooms in the order in which they were entered. Rooms that are not among `rooms`
  // are walked through, as if they were part of the doors; an empty name breaks the walk off. A
  // door leads both ways.
  RoomTopology(std::vector<std::string> rooms, std::span<const std::string> walk);

  [[nodiscard]] const std::vector<std::string>& rooms() const { return rooms_; }
  // How often the walk went from room a to room b or back.
  [[nodiscard]] const Eigen::MatrixXd& transition_counts() const { return transition_counts_; }
  // Where one gets to who leaves a room: row a, column b, each row adds up to 1 (to 0 where there
  // is one room alone). A walk need not use every door: a tenth goes to all rooms alike, and all
  // of it from a room that the walk never left.
  [[nodiscard]] Eigen::MatrixXd transition_probabilities() const;

 private:
  std::vector<std::string> rooms_;
  Eigen::MatrixXd transition_counts_;
};

}  // namespace roomwise::rooms
