#include "roomwise/rooms/learning/visit_learning.h"

#include <algorithm>

namespace roomwise::rooms {
namespace {

// A picture that is more similar to what is remembered than held-out pictures are, by so many of
// their standard deviations, brings nothing new: so are about half of a development home's own
// pictures to their neighbours on the walk (docs/experiments/rooms-refresh.md).
constexpr double kNothingNew_deviations = 1.5;

// Of `left`, which is not empty: the least similar to what is remembered, and how similar it is.
Expected<std::pair<std::size_t, double>> lowest_similarity(const RoomClassifier& classifier,
                                                           std::span<const RoomPicture> pictures,
                                                           std::span<const std::size_t> left) {
  std::pair<std::size_t, double> least{left.front(), 0};
  for (const std::size_t i : left) {
    ROOMWISE_TRY(const Similarity similarity, classifier.similarity(pictures[i].features));
    const double deviations = classifier.retrieval().calibration.deviations(similarity);
    if (i == left.front() || deviations < least.second) least = {i, deviations};
  }
  return least;
}

}  // namespace

Expected<void> VisitLearningOptions::validate() const {
  if (!(min_inside > 0.5 && min_inside < 1)) {
    return fail("min_inside is {}; expected more than 0.5 and less than 1", min_inside);
  }
  if (max_of_visit == 0) return fail("max_of_visit is 0; expected at least 1");
  if (max_of_room < max_of_visit) {
    return fail("max_of_room is {}; expected at least max_of_visit ({})", max_of_room,
                max_of_visit);
  }
  return {};
}

std::optional<std::size_t> room_by_place(const LocalizationEvidence& place,
                                         const VisitLearningOptions& options) {
  Eigen::Index best = 0;
  const double inside = place.probabilities.maxCoeff(&best);
  if (place.log_likelihood_ratio <= 0 || inside < options.min_inside) return std::nullopt;
  return static_cast<std::size_t>(best);
}

std::optional<std::size_t> room_by_picture(const PictureEvidence& picture,
                                           const RoomDecision& along_walk,
                                           std::span<const std::string> names) {
  Eigen::Index best = 0;
  picture.probabilities.maxCoeff(&best);
  const auto room = static_cast<std::size_t>(best);
  const bool is_told = picture.familiarity >= 0 && along_walk.room() == names[room];
  return is_told ? std::optional(room) : std::nullopt;
}

Expected<std::vector<std::size_t>> choose_pictures(
    const RoomClassifier& classifier, std::span<const RoomPicture> agreed,
    const VisitLearningOptions& options, const std::map<std::string, std::size_t>& remembered) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  std::vector<std::size_t> chosen;
  RoomClassifier knowing = classifier;
  for (const std::string& room : classifier.rooms()) {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < agreed.size(); ++i) {
      if (agreed[i].room == room) left.push_back(i);
    }
    const auto before = remembered.find(room);
    std::size_t count = before == remembered.end() ? 0 : before->second;
    for (; count < options.max_of_visit && !left.empty(); ++count) {
      ROOMWISE_TRY(const auto lowest, lowest_similarity(knowing, agreed, left));
      if (lowest.second >= kNothingNew_deviations) break;
      ROOMWISE_TRY(knowing, knowing.with(agreed.subspan(lowest.first, 1)));
      std::erase(left, lowest.first);
      chosen.push_back(lowest.first);
    }
  }
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace roomwise::rooms
