#include "roomwise/objects/instances/evidence.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

constexpr double kSmallSum = 0.1;  // of scores, so that logarithms of ratios stay finite
constexpr double kOnFloor_m = 0.15;

double sum_of_scores(const Candidate& candidate, std::span<const WorldObservation> observations) {
  double sum = 0;
  for (const std::size_t i : candidate.group) {
    sum += static_cast<double>(observations[i].detection->score);
  }
  return sum;
}

std::set<std::size_t> keyframes_of(const Candidate& candidate,
                                   std::span<const WorldObservation> observations) {
  std::set<std::size_t> keyframes;
  for (const std::size_t i : candidate.group) keyframes.insert(observations[i].keyframe);
  return keyframes;
}

double log_ratio(double of, double to) {
  return std::log((of + kSmallSum) / (to + kSmallSum));
}

// Whether two candidates of different classes may be one thing: they are in one place.
bool are_rivals(const Candidate& a, const Candidate& b) {
  const double apart_m = std::min((a.middle_world - b.middle_world).norm(),
                                  (a.box_world.center() - b.box_world.center()).norm());
  return a.class_name != b.class_name && apart_m <= 0.25 * (a.extent_m() + b.extent_m()) + 0.1;
}

// Within which another candidate of its class may be the same thing.
double twin_reach_m(const Candidate& candidate) {
  return 1.5 * typical_length_m(candidate.class_name);
}

// Standings among the others.
struct Others {
  double strongest_rival = 0;
  // The strongest of its class near by, where that one is stronger.
  std::optional<std::size_t> twin;
};

class EvidenceMaker {
 public:
  EvidenceMaker(std::span<const Candidate> candidates, std::span<const Visibility> visibility,
                std::span<const WorldObservation> observations, const GroundPlane& level)
      : candidates_(candidates), visibility_(visibility), level_(level) {
    for (const Candidate& candidate : candidates) {
      sums_.push_back(sum_of_scores(candidate, observations));
      keyframes_of_.push_back(keyframes_of(candidate, observations));
    }
  }

  [[nodiscard]] Evidence of(std::size_t index) const {
    const Candidate& candidate = candidates_[index];
    const Others others = others_of(index);
    const OfTwin twin = of_twin(index, others.twin);
    const Visibility& visibility = visibility_[index];
    const double larger = std::log(candidate.extent_m() / usual_extent_m(candidate.class_name));
    const Kind* kind = find_kind(candidate.class_name);
    const double foot_m =
        level_.height_m(candidate.box_world.center()) - candidate.box_world.size_m.z() / 2;
    const bool is_misplaced =
        kind != nullptr && !kind->stands_on_floor && level_.is_floor_known && foot_m < kOnFloor_m;
    return {std::log1p(sums_[index]),
            static_cast<double>(visibility.observed) / (visibility.observed + visibility.missed),
            log_ratio(sums_[index], others.strongest_rival),
            twin.lead,
            twin.nearness,
            twin.together,
            std::clamp(larger, 0.0, 2.0),
            is_misplaced ? 1.0 : 0.0};
  }

 private:
  [[nodiscard]] Others others_of(std::size_t index) const {
    Others others;
    const Candidate& candidate = candidates_[index];
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (i == index) continue;
      if (candidates_[i].class_name == candidate.class_name) {
        const double least = others.twin ? sums_[*others.twin] : sums_[index];
        const double apart_m = (candidate.middle_world - candidates_[i].middle_world).norm();
        if (sums_[i] > least && apart_m <= twin_reach_m(candidate)) others.twin = i;
      } else if (are_rivals(candidate, candidates_[i])) {
        others.strongest_rival = std::max(others.strongest_rival, sums_[i]);
      }
    }
    return others;
  }

  struct OfTwin {
    double lead = 0, nearness = 0, together = 0;
  };
  [[nodiscard]] OfTwin of_twin(std::size_t index, const std::optional<std::size_t>& twin) const {
    if (!twin) return {};
    const Candidate& candidate = candidates_[index];
    std::vector<std::size_t> both;
    std::ranges::set_intersection(keyframes_of_[index], keyframes_of_[*twin],
                                  std::back_inserter(both));
    const double apart_m = (candidate.middle_world - candidates_[*twin].middle_world).norm();
    return {log_ratio(sums_[*twin], sums_[index]),
            std::max(0.0, 1 - apart_m / twin_reach_m(candidate)),
            static_cast<double>(both.size()) / static_cast<double>(keyframes_of_[index].size())};
  }

  std::span<const Candidate> candidates_;
  std::span<const Visibility> visibility_;
  const GroundPlane& level_;
  std::vector<double> sums_;
  std::vector<std::set<std::size_t>> keyframes_of_;
};

}  // namespace

Visibility visibility_of(const Candidate& candidate, std::span<const WorldObservation> observations,
                         std::span<const ObservedKeyframe> keyframes, double max_range_m) {
  const std::set<std::size_t> observed = keyframes_of(candidate, observations);
  std::set<DetectionSource> sources;
  for (const std::size_t i : candidate.group) sources.insert(observations[i].detection->source);
  // That one is shown its best views alone, so the others say nothing against it.
  sources.erase(DetectionSource::kProposal);
  Visibility visibility{.observed = static_cast<int>(observed.size())};
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const bool was_looked_at = std::ranges::any_of(sources, [&](DetectionSource source) {
      return !keyframes[k].sources_not_run.contains(source);
    });
    if (observed.contains(k) || !was_looked_at) continue;
    if (should_see(keyframes[k], candidate.surface_world, max_range_m)) ++visibility.missed;
  }
  return visibility;
}

std::vector<Evidence> evidence_of(std::span<const Candidate> candidates,
                                  std::span<const Visibility> visibility,
                                  std::span<const WorldObservation> observations,
                                  const GroundPlane& level) {
  const EvidenceMaker maker(candidates, visibility, observations, level);
  std::vector<Evidence> evidence;
  for (std::size_t i = 0; i < candidates.size(); ++i) evidence.push_back(maker.of(i));
  return evidence;
}

}  // namespace roomwise::objects
