#include "roomwise/rooms/recognition/room_decision.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

// How much two pictures of one place say the same. Of 0, 0.25, 0.5, 0.75 and 1 this one gives the
// pairs of held-out pictures their best probabilities
// (docs/experiments/rooms-correlation-of-pictures.md).
constexpr double kCorrelation = 0.5;
// No picture rules a room out.
constexpr double kMinProbability = 1e-6;
// How often an object that the network is quite sure of is there.
constexpr double kTrustInObjects = 0.7;

std::vector<RoomScore> best_first(const Eigen::VectorXd& probabilities,
                                  std::span<const std::string> names) {
  std::vector<RoomScore> scores;
  for (std::size_t i = 0; i < names.size(); ++i) {
    scores.push_back({names[i], probabilities[static_cast<Eigen::Index>(i)]});
  }
  std::ranges::stable_sort(scores, std::ranges::greater{}, &RoomScore::score);
  return scores;
}

// What is said of the two best rooms: "kitchen (0.51) or hall (0.44)".
std::string candidates(std::span<const RoomScore> rooms) {
  std::string text = fmt::format("{} ({:.2f})", rooms[0].room, rooms[0].score);
  if (rooms.size() > 1) text += fmt::format(" or {} ({:.2f})", rooms[1].room, rooms[1].score);
  return text;
}

// How much an object speaks for each room; the shares add up to 1, or are all 0 where it says
// nothing.
Eigen::VectorXd shares_of(const std::string& object, const Concepts& concepts,
                          std::span<const Room> rooms, const RoomObjects& learned) {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rooms.size()));
  const auto by_pictures = learned.shares(object);
  const auto type = by_pictures.empty() ? concepts.represented_room_type(object) : std::nullopt;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const auto found = by_pictures.find(rooms[i].name);
    const bool is_of_type = type && rooms[i].type == *type;
    shares[static_cast<Eigen::Index>(i)] =
        found != by_pictures.end() ? found->second : static_cast<double>(is_of_type);
  }
  const double sum = shares.sum();
  return sum > 0 ? Eigen::VectorXd(shares / sum) : shares;
}

// Whether an object speaks for a room as much as for any other, and for some other less.
bool speaks_for(const std::string& room, const Eigen::VectorXd& shares,
                std::span<const Room> rooms) {
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const double share = shares[static_cast<Eigen::Index>(i)];
    if (rooms[i].name == room) return share == shares.maxCoeff() && share > shares.minCoeff();
  }
  return false;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kRoom:
      return "room";
    case Verdict::kEither:
      return "either";
    case Verdict::kNotSure:
      return "not sure";
    case Verdict::kNoneOfThem:
      return "none of them";
  }
  return "unknown";
}

bool RoomDecision::allows(std::string_view room) const {
  if (verdict == Verdict::kRoom) return rooms.front().room == room;
  return verdict == Verdict::kEither && (rooms[0].room == room || rooms[1].room == room);
}

double effective_sample_size(double pictures) {
  return pictures / (1 + (pictures - 1) * kCorrelation);
}

PictureEvidence combine(std::span<const PictureEvidence> pictures) {
  if (pictures.empty()) throw std::invalid_argument("combine: no pictures");
  const auto count = static_cast<double>(pictures.size());
  const double counts_as = effective_sample_size(count);
  Eigen::ArrayXd logs = Eigen::ArrayXd::Zero(pictures.front().probabilities.size());
  PictureEvidence combined;
  for (const PictureEvidence& picture : pictures) {
    logs += picture.probabilities.array().max(kMinProbability).log() * (counts_as / count);
    combined.familiarity += picture.familiarity * (counts_as / count);
  }
  const Eigen::ArrayXd powers = (logs - logs.maxCoeff()).exp();
  combined.probabilities = powers / powers.sum();
  return combined;
}

Eigen::VectorXd likelihood_of_objects(std::span<const objects::ObjectScore> objects,
                                      const Concepts& concepts, std::span<const Room> rooms,
                                      const RoomObjects& learned) {
  const auto count = static_cast<Eigen::Index>(rooms.size());
  // A mixture: sum_i t_i n s_i + (1 - sum_i t_i). With the probability t_i that the network gives
  // object i, less what it is not trusted, the n rooms are as probable as the object's shares s_i;
  // else it says nothing.
  Eigen::VectorXd likelihood = Eigen::VectorXd::Zero(count);
  double trusted_in_all = 0;
  for (const objects::ObjectScore& observation : objects) {
    const Eigen::VectorXd shares = shares_of(observation.object, concepts, rooms, learned);
    if (shares.isZero()) continue;
    const double trusted = std::min(kTrustInObjects * observation.score, 1 - trusted_in_all);
    trusted_in_all += trusted;
    likelihood += trusted * static_cast<double>(count) * shares;
  }
  return likelihood.array() + (1 - trusted_in_all);
}

RoomDecision decide(const PictureEvidence& evidence, std::span<const std::string> names,
                    const RoomModel& model) {
  RoomDecision decision;
  decision.rooms = best_first(evidence.probabilities, names);
  decision.familiarity = evidence.familiarity;
  const double p_known = probability_of(evidence.familiarity);
  const double best = p_known * decision.rooms.front().score;
  const double best_two =
      decision.rooms.size() < 2 ? best : best + p_known * decision.rooms[1].score;
  if (evidence.familiarity < model.reject_log_odds) {
    decision.verdict = Verdict::kNoneOfThem;
    decision.why = fmt::format("nothing that was learned looks like this ({:.2f})", p_known);
  } else if (best >= model.min_probability) {
    decision.verdict = Verdict::kRoom;
    decision.why = fmt::format("it looks like {} ({:.2f})", decision.rooms.front().room, best);
  } else if (best_two >= model.min_probability) {
    decision.verdict = Verdict::kEither;
    decision.why = fmt::format("it looks like {}", candidates(decision.rooms));
  } else {
    decision.why = fmt::format(
        "it could be {}, and looks like what was learned by {:.2f}; a room is named from {:.2f} on",
        candidates(decision.rooms), p_known, model.min_probability);
  }
  return decision;
}

RoomDecision decide_with_objects(const PictureEvidence& evidence,
                                 std::span<const objects::ObjectScore> objects,
                                 const Concepts& concepts, std::span<const Room> rooms,
                                 const RoomModel& model, const RoomObjects& learned) {
  PictureEvidence weighed = evidence;
  weighed.probabilities =
      evidence.probabilities.cwiseProduct(likelihood_of_objects(objects, concepts, rooms, learned));
  weighed.probabilities /= weighed.probabilities.sum();
  std::vector<std::string> names;
  for (const Room& room : rooms) names.push_back(room.name);
  RoomDecision decision = decide(weighed, names, model);
  for (const objects::ObjectScore& observation : objects) {
    const Eigen::VectorXd shares = shares_of(observation.object, concepts, rooms, learned);
    if (!speaks_for(decision.rooms.front().room, shares, rooms)) continue;
    decision.object = observation.object;
    if (decision.verdict == Verdict::kRoom) {
      decision.why +=
          fmt::format(", and there is a {} ({:.2f})", observation.object, observation.score);
    }
    break;
  }
  return decision;
}

}  // namespace roomwise::rooms
