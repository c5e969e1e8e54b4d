#include "roomwise/rooms/place_evidence.h"

#include <algorithm>
#include <cmath>

#include "roomwise/rooms/room_decision.h"

namespace roomwise::rooms {
namespace {

using mapping::LocalizationStatus;

// How much oftener the localiser answers so to pictures of the map's home, in other light or with
// things moved, than to those of another home: the logarithm of the ratio (docs/rooms.md).
constexpr double kSureLogRatio = 5;      // a place by features, or by shape with this much support
constexpr double kSureSupport = 1.4;     // with less, other homes' doors and walls fit as often
constexpr double kPlainLogRatio = -2;    // a bare wall
constexpr double kNowhereLogRatio = -3;  // nothing alike, or too little speaks for the pose
// A standard deviation of RoomCalibration::known in the logarithm of the odds of this home.
constexpr double kLogOddsPerDeviation = 2.5;
// How often the floor at a pose is that of another room than the camera was in, where no doorway is
// near: wrong poses, and faults of the layout.
constexpr double kWrongRoom = 0.01;
// The line between two rooms is not known better, and people cross it a step early or late, m.
constexpr double kBoundarySigma_m = 0.15;
// How far a person walks from one picture of a pair to the next, m.
constexpr double kStepSigma_m = 0.5;

double home_log_ratio(const mapping::Localization& answer, bool has_depth) {
  const bool is_by_shape = answer.witnesses > 0;
  switch (answer.status) {
    case LocalizationStatus::kFound:
      return is_by_shape && answer.support < kSureSupport ? 0 : kSureLogRatio;
    case LocalizationStatus::kAmbiguous:
    case LocalizationStatus::kVague:
      return 0;
    case LocalizationStatus::kPlain:
      return has_depth ? kPlainLogRatio : 0;
    default:
      return has_depth ? kNowhereLogRatio : 0;
  }
}

std::string place_in_words(const Eigen::VectorXd& inside, std::span<const std::string> rooms) {
  constexpr double kWorthNaming = 0.05;
  std::vector<RoomScore> named;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const double share = inside[static_cast<Eigen::Index>(i)];
    if (share >= kWorthNaming) named.push_back({rooms[i], share});
  }
  std::ranges::stable_sort(named, std::ranges::greater{}, &RoomScore::score);
  if (named.empty()) return "its place on the map is in no room";
  if (named.size() == 1) return fmt::format("its place on the map is in {}", named[0].room);
  return fmt::format("its place on the map is between {} and {}", named[0].room, named[1].room);
}

// `moved_sigma_m`: how far from the place that was found the camera may be by now.
PlaceEvidence evidence_of(const mapping::Localization& answer, bool has_depth, double moved_sigma_m,
                          const fusion::LevelFrame& frame, const std::optional<RoomLayout>& layout,
                          std::span<const std::string> rooms) {
  const auto count = static_cast<Eigen::Index>(rooms.size());
  PlaceEvidence evidence;
  evidence.probabilities = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
  evidence.home_log_ratio = home_log_ratio(answer, has_depth);
  if (!answer.found()) {
    evidence.why = fmt::format("no place on the map ({})", to_string(answer.status));
    return evidence;
  }
  Eigen::VectorXd inside = Eigen::VectorXd::Zero(count);
  if (layout) {
    const Eigen::Vector3d camera_level =
        frame.level_from_world * answer.world_from_camera.translation;
    const double sigma_m = std::hypot(answer.position_sigma_m(), kBoundarySigma_m, moved_sigma_m);
    const std::vector<double> shares = layout->shares_around(camera_level.head<2>(), sigma_m);
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const auto room = std::ranges::find(rooms, layout->rooms()[i].name);
      if (room != rooms.end()) inside[room - rooms.begin()] += shares[i];
    }
  }
  evidence.why = layout ? place_in_words(inside, rooms) : "the map has no rooms";
  // What lies in none of the rooms may be any of them.
  const double told = (1 - kWrongRoom) * inside.sum();
  evidence.probabilities = (1 - kWrongRoom) * inside + (1 - told) * evidence.probabilities;
  return evidence;
}

}  // namespace

PlaceEvidence place_evidence(const mapping::Localization& answer, bool has_depth,
                             const fusion::LevelFrame& frame,
                             const std::optional<RoomLayout>& layout,
                             std::span<const std::string> rooms) {
  return evidence_of(answer, has_depth, 0, frame, layout, rooms);
}

PlaceEvidence place_evidence(const mapping::PairLocalization& answers, bool has_depth,
                             const fusion::LevelFrame& frame,
                             const std::optional<RoomLayout>& layout,
                             std::span<const std::string> rooms) {
  const auto& [first, second, contradictory] = answers;
  if (first.found() && !second.found() && !contradictory) {
    return evidence_of(first, has_depth, kStepSigma_m, frame, layout, rooms);
  }
  PlaceEvidence evidence = evidence_of(second, has_depth, 0, frame, layout, rooms);
  if (contradictory) evidence.home_log_ratio = 0;
  if (!first.found() && !second.found()) {
    evidence.home_log_ratio =
        independent_count(2) / 2 *
        (home_log_ratio(first, has_depth) + home_log_ratio(second, has_depth));
  }
  return evidence;
}

bool place_may_tell(const PictureEvidence& pictures, const RoomCalibration& calibration) {
  const bool is_named = pictures.known >= calibration.known_from &&
                        pictures.probabilities.maxCoeff() >= calibration.sure_from;
  const double least_log_ratio = independent_count(2) * kNowhereLogRatio;
  return !is_named ||
         pictures.known + least_log_ratio / kLogOddsPerDeviation < calibration.known_from;
}

PictureEvidence with_place(const PictureEvidence& pictures, const PlaceEvidence& place,
                           const RoomCalibration& calibration) {
  PictureEvidence joined;
  joined.probabilities = pictures.probabilities.cwiseProduct(place.probabilities);
  joined.probabilities /= joined.probabilities.sum();
  joined.known = std::max(pictures.known, calibration.none_below) +
                 place.home_log_ratio / kLogOddsPerDeviation;
  return joined;
}

}  // namespace roomwise::rooms
