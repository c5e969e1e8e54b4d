#include "roomwise/objects/detection/confirmed_objects.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>

namespace roomwise::objects {
namespace {

void expect_same_length(std::span<const float> scores, std::span<const std::string> labels) {
  if (scores.size() != labels.size()) {
    throw std::invalid_argument("objects: scores and labels differ in number");
  }
}

// The observations of the given labels: an object has the highest score of its labels. Best first;
// equal scores by name.
std::vector<ObjectScore> observations_of(std::span<const std::size_t> chosen,
                                         std::span<const float> scores,
                                         std::span<const std::string> labels,
                                         const ObjectVocabulary& vocabulary) {
  std::map<std::string, double> score_of;
  for (const std::size_t i : chosen) {
    const auto object = vocabulary.object_of(labels[i]);
    if (!object) continue;
    double& score = score_of[*object];
    score = std::max(score, static_cast<double>(scores[i]));
  }
  std::vector<ObjectScore> observations;
  for (const auto& [object, score] : score_of) observations.push_back({object, score});
  std::ranges::stable_sort(observations, std::ranges::greater{}, &ObjectScore::score);
  return observations;
}

// Key-frames in a row that confirm an object: [first, last] of the views.
struct Run {
  std::size_t first = 0;
  std::size_t last = 0;
};

// The score of one object in each view; absent where it is not seen well enough (rule 1).
std::vector<std::optional<double>> scores_along(std::span<const KeyframeView> views,
                                                const std::string& object, double min_score) {
  std::vector<std::optional<double>> scores(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const ObjectScore& observation : views[i].observations) {
      if (observation.object == object && observation.score >= min_score) {
        scores[i] = std::max(scores[i].value_or(0), observation.score);
      }
    }
  }
  return scores;
}

// Rule 3. Windows that confirm the object and overlap are one run: one pass of the camera.
std::vector<Run> confirmed_runs(std::span<const std::optional<double>> scores,
                                std::span<const KeyframeView> views, const ObjectRules& rules) {
  std::vector<Run> runs;
  const auto window = static_cast<std::size_t>(rules.window);
  for (std::size_t first = 0; first < scores.size(); ++first) {
    std::size_t end = first + 1;
    while (end < std::min(first + window, scores.size()) && views[end].is_continuous) ++end;
    const auto seen = std::count_if(scores.begin() + static_cast<std::ptrdiff_t>(first),
                                    scores.begin() + static_cast<std::ptrdiff_t>(end),
                                    [](const auto& score) { return score.has_value(); });
    if (seen < rules.min_observations) continue;
    if (!runs.empty() && first <= runs.back().last) {
      runs.back().last = end - 1;
    } else {
      runs.push_back({first, end - 1});
    }
  }
  return runs;
}

// One object from one run: the key-frame with the highest score, the first where several have it.
ConfirmedObject object_of_run(const Run& run, const std::string& name,
                              std::span<const std::optional<double>> scores,
                              std::span<const KeyframeView> views) {
  ConfirmedObject object;
  object.name = name;
  for (std::size_t i = run.first; i <= run.last; ++i) {
    if (!scores[i]) continue;
    if (object.observations++ == 0 || *scores[i] > object.score) {
      object.keyframe_id = views[i].keyframe_id;
      object.score = *scores[i];
      object.position_keyframe = views[i].center_point;
    }
  }
  return object;
}

// Objects of one name that stand closer than the distance become one, which keeps the place of the
// better seen. Those without a place stay apart: nothing says that they are the same.
std::vector<ConfirmedObject> merge_close(
    std::vector<ConfirmedObject> objects, double distance_m,
    const std::function<geometry::RigidTransform(std::uint64_t)>& world_from_keyframe) {
  std::ranges::stable_sort(objects, std::ranges::greater{}, &ConfirmedObject::score);
  const auto place = [&](const ConfirmedObject& object) -> Eigen::Vector3d {
    return world_from_keyframe(object.keyframe_id) * *object.position_keyframe;
  };
  std::vector<ConfirmedObject> merged;
  for (const ConfirmedObject& object : objects) {
    const auto same = std::ranges::find_if(merged, [&](const ConfirmedObject& other) {
      return object.position_keyframe && other.position_keyframe &&
             (place(object) - place(other)).norm() < distance_m;
    });
    if (same == merged.end()) {
      merged.push_back(object);
    } else {
      same->observations += object.observations;
    }
  }
  return merged;
}

}  // namespace

std::vector<ObjectScore> observations_in(std::span<const float> scores,
                                         std::span<const std::string> labels,
                                         const ObjectVocabulary& vocabulary, double min_score) {
  expect_same_length(scores, labels);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (static_cast<double>(scores[i]) >= min_score) chosen.push_back(i);
  }
  return observations_of(chosen, scores, labels, vocabulary);
}

std::vector<ObjectScore> top_objects(std::span<const float> scores,
                                     std::span<const std::string> labels,
                                     const ObjectVocabulary& vocabulary, std::size_t most) {
  expect_same_length(scores, labels);
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return scores[i]; });
  order.resize(std::min(most, order.size()));
  return observations_of(order, scores, labels, vocabulary);
}

Expected<void> ObjectRules::validate() const {
  if (!(min_score > 0 && min_score <= 1)) {
    return fail("min_score is {}; expected a probability over 0 and at most 1", min_score);
  }
  if (window < 1) return fail("window is {}; expected at least 1 key-frame", window);
  if (min_observations < 1 || min_observations > window) {
    return fail("min_observations is {}; expected 1 to window ({})", min_observations, window);
  }
  if (!(same_object_distance_m >= 0 && std::isfinite(same_object_distance_m))) {
    return fail("same_object_distance_m is {}; expected 0 m or more", same_object_distance_m);
  }
  return {};
}

std::vector<ConfirmedObject> confirm_objects(
    std::span<const KeyframeView> views, const ObjectRules& rules,
    const std::function<geometry::RigidTransform(std::uint64_t keyframe_id)>& world_from_keyframe) {
  std::set<std::string> names;
  for (const KeyframeView& view : views) {
    for (const ObjectScore& observation : view.observations) names.insert(observation.object);
  }
  std::vector<ConfirmedObject> objects;
  for (const std::string& name : names) {
    const auto scores = scores_along(views, name, rules.min_score);
    std::vector<ConfirmedObject> of_name;
    for (const Run& run : confirmed_runs(scores, views, rules)) {
      of_name.push_back(object_of_run(run, name, scores, views));
    }
    of_name = merge_close(std::move(of_name), rules.same_object_distance_m, world_from_keyframe);
    objects.insert(objects.end(), of_name.begin(), of_name.end());
  }
  std::ranges::sort(objects, {}, [](const ConfirmedObject& object) {
    return std::tie(object.name, object.keyframe_id);
  });
  return objects;
}

}  // namespace roomwise::objects
