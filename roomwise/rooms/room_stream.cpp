#include "roomwise/rooms/room_stream.h"

#include <algorithm>
#include <cmath>

namespace roomwise::rooms {
namespace {

// So long one stays in the learned rooms, or elsewhere, on average, s.
constexpr double kMeanStay_s = 120;
// No picture is surer than this, in the logarithm of the odds.
constexpr double kMostLogOdds = 3;

}  // namespace

void RoomStream::believe(const PictureEvidence& picture, double elapsed_s) {
  const double said =
      std::clamp(RoomCalibration::kLogOddsPerDeviation * (picture.known - calibration_.known_from),
                 -kMostLogOdds, kMostLogOdds);
  if (!has_seen_) {
    log_odds_ = said;
    has_seen_ = true;
    return;
  }
  // Two states that are left equally often come to be equally probable.
  const double unchanged = std::exp(-2 * elapsed_s / kMeanStay_s);
  const double probability = 0.5 + unchanged * (1 / (1 + std::exp(-log_odds_)) - 0.5);
  log_odds_ = std::log(probability / (1 - probability)) + options_.weight_after(elapsed_s) * said;
}

RoomDecision RoomStream::see(const PictureEvidence& picture, double elapsed_s) {
  const Eigen::VectorXd& seen = picture.probabilities;
  if (!(elapsed_s > 0)) elapsed_s = 0;
  filter_.see({seen.data(), static_cast<std::size_t>(seen.size())}, elapsed_s);
  believe(picture, elapsed_s);
  const double known = calibration_.known_from + log_odds_ / RoomCalibration::kLogOddsPerDeviation;
  return decide(PictureEvidence{filter_.belief(), known}, filter_.rooms(), calibration_);
}

}  // namespace roomwise::rooms
