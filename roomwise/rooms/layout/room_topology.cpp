#include "roomwise/rooms/layout/room_topology.h"

#include <algorithm>

namespace roomwise::rooms {
namespace {

constexpr double kUnseenDoors = 0.1;  // of leaving a room: by a door that the walk did not use

}  // namespace

RoomTopology::RoomTopology(std::vector<std::string> rooms) : RoomTopology(std::move(rooms), {}) {}

RoomTopology::RoomTopology(std::vector<std::string> rooms, std::span<const std::string> walk)
    : rooms_(std::move(rooms)) {
  const auto count = static_cast<Eigen::Index>(rooms_.size());
  transition_counts_ = Eigen::MatrixXd::Zero(count, count);
  constexpr Eigen::Index kNone = -1;
  Eigen::Index last = kNone;
  for (const std::string& room : walk) {
    if (room.empty()) {
      last = kNone;
      continue;
    }
    const Eigen::Index now = std::ranges::find(rooms_, room) - rooms_.begin();
    if (now == count || last == now) continue;
    if (last != kNone) {
      transition_counts_(last, now) += 1;
      transition_counts_(now, last) += 1;
    }
    last = now;
  }
}

Eigen::MatrixXd RoomTopology::transition_probabilities() const {
  const Eigen::Index count = transition_counts_.rows();
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const double left = transition_counts_.row(a).sum();
    const double unseen = left > 0 ? kUnseenDoors : 1;
    for (Eigen::Index b = 0; b < count; ++b) {
      if (a == b) continue;
      shares(a, b) = unseen / static_cast<double>(count - 1);
      if (left > 0) shares(a, b) += (1 - unseen) * transition_counts_(a, b) / left;
    }
  }
  return shares;
}

}  // namespace roomwise::rooms
