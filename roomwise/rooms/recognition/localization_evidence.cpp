#include "roomwise/rooms/recognition/localization_evidence.h"

#include <algorithm>
#include <cmath>

#include "roomwise/rooms/recognition/room_decision.h"

namespace roomwise::rooms {
namespace {

using mapping::LocalizationStatus;

// How much oftener the localiser answers so to pictures of the map's home, in other light or with
// things moved, than to those of another home: the logarithm of the ratio
// (docs/experiments/rooms-place-log-ratios.md).
constexpr double kSureLogRatio = 5;    // a place by many features, or by shape with much support
constexpr double kLikelyLogRatio = 2;  // by few features, or with some support
constexpr int kManyInliers = 16;
constexpr double kMuchSupport = 1.4, kSomeSupport = 0.8;  // other homes' doors and walls fit, too
constexpr double kNoPlaceLogRatio = -2;    // a bare wall, nothing alike, or too little for a pose
constexpr double kElsewhereLogRatio = -3;  // a place in a room that was not learned
// How often the floor at a pose is that of another room than the camera was in, where no doorway is
// near: wrong poses, and faults of the layout.
constexpr double kWrongRoom = 0.01;
// The line between two rooms is not known better, and people cross it a step early or late, m.
constexpr double kBoundarySigma_m = 0.15;
// How far a person walks from one picture of a pair to the next, m.
constexpr double kStepSigma_m = 0.5;

double found_log_ratio(const mapping::Localization& answer) {
  if (answer.is_weak_hypothesis) return 0;  // another home has windows and tiles, too
  const bool is_by_shape = answer.supporting_keyframes > 0;
  const bool is_sure =
      is_by_shape ? answer.support >= kMuchSupport : answer.inliers >= kManyInliers;
  if (is_sure) return kSureLogRatio;
  return is_by_shape && answer.support < kSomeSupport ? 0 : kLikelyLogRatio;
}

double log_likelihood_ratio(const mapping::Localization& answer, bool has_depth) {
  switch (answer.status) {
    case LocalizationStatus::kFound:
      return found_log_ratio(answer);
    case LocalizationStatus::kAmbiguous:
    case LocalizationStatus::kVague:
      return 0;
    default:
      return has_depth ? kNoPlaceLogRatio : 0;
  }
}

// On whose floor a pose lies; the shares add up to 1 with what lies on no floor.
struct FloorShares {
  Eigen::VectorXd learned;        // in the order of the learned rooms
  std::vector<RoomScore> on_map;  // of every floor, for people
  double elsewhere = 0;           // on floors of rooms that were not learned, or have no name
};

FloorShares floor_shares(const RoomLayout& layout, const Eigen::Vector2d& point_plan,
                         double sigma_m, std::span<const std::string> rooms) {
  FloorShares found{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rooms.size())), {}, 0};
  const std::vector<double> shares = layout.room_probabilities(point_plan, sigma_m);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const std::string& name = layout.rooms()[i].name;
    const auto room = std::ranges::find(rooms, name);
    if (room != rooms.end()) {
      found.learned[room - rooms.begin()] += shares[i];
      found.on_map.push_back({name, shares[i]});
    } else {
      found.elsewhere += shares[i];
      found.on_map.push_back({name + ", which was not learned", shares[i]});
    }
  }
  const double nameless = layout.nameless_share_around(point_plan, sigma_m);
  found.elsewhere += nameless;
  found.on_map.push_back({"a room without a name", nameless});
  return found;
}

std::string place_in_words(std::vector<RoomScore> named) {
  constexpr double kWorthNaming = 0.05;
  std::erase_if(named, [](const RoomScore& one) { return one.score < kWorthNaming; });
  std::ranges::stable_sort(named, std::ranges::greater{}, &RoomScore::score);
  if (named.empty()) return "its place on the map is in no room";
  if (named.size() == 1) return fmt::format("its place on the map is in {}", named[0].room);
  return fmt::format("its place on the map is between {} and {}", named[0].room, named[1].room);
}

// `moved_sigma_m`: how far from the place that was found the camera may be by now.
LocalizationEvidence evidence_of(const mapping::Localization& answer, bool has_depth,
                                 double moved_sigma_m, const fusion::GravityAlignedFrame& frame,
                                 const std::optional<RoomLayout>& layout,
                                 std::span<const std::string> rooms) {
  const auto count = static_cast<Eigen::Index>(rooms.size());
  LocalizationEvidence evidence;
  evidence.probabilities = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
  evidence.log_likelihood_ratio = log_likelihood_ratio(answer, has_depth);
  if (!answer.found()) {
    evidence.why = fmt::format("no place on the map ({})", to_string(answer.status));
    return evidence;
  }
  if (!layout || !layout->has_floor()) {
    evidence.why = "the map has no rooms";
    return evidence;
  }
  const Eigen::Vector3d camera_plan = frame.on_plan(answer.world_from_camera.translation);
  const double sigma_m = std::hypot(answer.position_sigma_m(), kBoundarySigma_m, moved_sigma_m);
  const FloorShares shares = floor_shares(*layout, camera_plan.head<2>(), sigma_m, rooms);
  evidence.why = place_in_words(shares.on_map);
  evidence.log_likelihood_ratio =
      shares.learned.sum() * evidence.log_likelihood_ratio + shares.elsewhere * kElsewhereLogRatio;
  // What lies in none of the rooms may be any of them.
  const double told = (1 - kWrongRoom) * shares.learned.sum();
  evidence.probabilities = (1 - kWrongRoom) * shares.learned + (1 - told) * evidence.probabilities;
  return evidence;
}

}  // namespace

LocalizationEvidence localization_evidence(const mapping::Localization& answer, bool has_depth,
                                           const fusion::GravityAlignedFrame& frame,
                                           const std::optional<RoomLayout>& layout,
                                           std::span<const std::string> rooms) {
  return evidence_of(answer, has_depth, 0, frame, layout, rooms);
}

LocalizationEvidence localization_evidence(const mapping::PairLocalization& answers, bool has_depth,
                                           const fusion::GravityAlignedFrame& frame,
                                           const std::optional<RoomLayout>& layout,
                                           std::span<const std::string> rooms) {
  const auto& [first, second, contradictory] = answers;
  const LocalizationEvidence before =
      evidence_of(first, has_depth, kStepSigma_m, frame, layout, rooms);
  const LocalizationEvidence now = evidence_of(second, has_depth, 0, frame, layout, rooms);
  LocalizationEvidence evidence = first.found() && !second.found() && !contradictory ? before : now;
  // Without depth, that there is no place says nothing.
  const int speak = has_depth ? 2 : int{first.found()} + int{second.found()};
  evidence.log_likelihood_ratio =
      contradictory || speak == 0 ? 0
                                  : effective_sample_size(speak) / speak *
                                        (before.log_likelihood_ratio + now.log_likelihood_ratio);
  return evidence;
}

bool place_may_tell(const PictureEvidence& pictures, const RoomModel& model) {
  // Named even if the place speaks against it as much as one can.
  const double familiarity = pictures.familiarity + effective_sample_size(2) * kElsewhereLogRatio;
  return probability_of(familiarity) * pictures.probabilities.maxCoeff() < model.min_probability;
}

PictureEvidence with_place(const PictureEvidence& pictures, const LocalizationEvidence& place,
                           const RoomModel& model) {
  PictureEvidence joined;
  joined.probabilities = pictures.probabilities.cwiseProduct(place.probabilities);
  joined.probabilities /= joined.probabilities.sum();
  joined.familiarity =
      std::max(pictures.familiarity, model.reject_log_odds) + place.log_likelihood_ratio;
  return joined;
}

}  // namespace roomwise::rooms
