#include "roomwise/rooms/recognition/room_stream.h"

#include <cmath>

namespace roomwise::rooms {
namespace {

// Over so long the familiarity is averaged.
constexpr double kAveraged_s = 2;

}  // namespace

RoomDecision RoomStream::update(const PictureEvidence& picture, double elapsed_s) {
  const Eigen::VectorXd& seen = picture.probabilities;
  if (!(elapsed_s > 0)) elapsed_s = 0;
  filter_.update({seen.data(), static_cast<std::size_t>(seen.size())}, elapsed_s);
  const double share = has_seen_ ? 1 - std::exp(-elapsed_s / kAveraged_s) : 1;
  familiarity_ += share * (picture.familiarity - familiarity_);
  has_seen_ = true;
  return decide(PictureEvidence{filter_.belief(), familiarity_}, filter_.rooms(), model_);
}

}  // namespace roomwise::rooms
