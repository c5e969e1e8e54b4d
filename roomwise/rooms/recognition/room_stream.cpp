#include "roomwise/rooms/recognition/room_stream.h"

#include <cmath>

namespace roomwise::rooms {
namespace {

// Over so long it is averaged how well the pictures are known, s.
constexpr double kKnownOver = 2;

}  // namespace

RoomDecision RoomStream::update(const PictureEvidence& picture, double elapsed_s) {
  const Eigen::VectorXd& seen = picture.probabilities;
  if (!(elapsed_s > 0)) elapsed_s = 0;
  filter_.update({seen.data(), static_cast<std::size_t>(seen.size())}, elapsed_s);
  const double share = has_seen_ ? 1 - std::exp(-elapsed_s / kKnownOver) : 1;
  known_ += share * (picture.known - known_);
  has_seen_ = true;
  return decide(PictureEvidence{filter_.belief(), known_}, filter_.rooms(), calibration_);
}

}  // namespace roomwise::rooms
