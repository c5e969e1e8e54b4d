#include "roomwise/objects/instances/instances.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "roomwise/objects/instances/evidence.h"
#include "roomwise/objects/instances/instance_model.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

// A candidate with how probable it is.
struct Hypothesis {
  const Candidate* candidate = nullptr;
  Visibility visibility;
  double probability = 0;
};

// Whether two candidates fill the same space, so that one of them at most is a thing: of like
// volume, and half of one in the other.
bool share_space(const Candidate& a, const Candidate& b) {
  constexpr double kLikeVolume = 0.3, kInside = 0.5;
  const auto [smaller, larger] =
      std::minmax({a.box_world.size_m.prod(), b.box_world.size_m.prod()});
  return smaller >= kLikeVolume * larger &&
         std::max(share_inside(a.box_world, b.box_world), share_inside(b.box_world, a.box_world)) >=
             kInside;
}

// The most probable first; each with what it gave way to.
struct Thing {
  Hypothesis hypothesis;
  std::map<std::string, double> names;  // the most probable hypothesis of each
};
std::vector<Thing> each_once(std::vector<Hypothesis> hypotheses) {
  std::ranges::stable_sort(hypotheses, std::ranges::greater(), &Hypothesis::probability);
  std::vector<Thing> things;
  for (const Hypothesis& one : hypotheses) {
    const auto same = std::ranges::find_if(things, [&](const Thing& thing) {
      return share_space(*one.candidate, *thing.hypothesis.candidate);
    });
    if (same == things.end()) {
      things.push_back({one, {{one.candidate->class_name, one.probability}}});
    } else {
      same->names.emplace(one.candidate->class_name, one.probability);  // unless it is there
    }
  }
  return things;
}

Instance instance_of(const Thing& thing, std::span<const WorldObservation> observations,
                     std::span<const ObservedKeyframe> keyframes, const InstanceModel& model) {
  const Candidate& candidate = *thing.hypothesis.candidate;
  Instance instance;
  instance.name = candidate.class_name;
  instance.probability = thing.hypothesis.probability;
  double sum = 0;
  for (const auto& [name, probability] : thing.names) sum += probability;
  for (const auto& [name, probability] : thing.names) instance.names[name] = probability / sum;
  const Visibility& visibility = thing.hypothesis.visibility;
  instance.observations = visibility.observed;
  instance.expected = visibility.observed + visibility.missed;
  const WorldObservation& best = observations[candidate.group.front()];
  const ObservedKeyframe& keyframe = keyframes[best.keyframe];
  instance.keyframe_id = keyframe.keyframe_id;
  instance.picture_box = best.detection->box;
  instance.box_keyframe = {
      keyframe.world_from_camera.inverse() * candidate.box_world.world_from_box,
      candidate.box_world.size_m};
  instance.sigma_m = model.sigma_m(candidate);
  return instance;
}

bool is_spoken_of(const std::string& class_name) {
  const Kind* kind = find_kind(class_name);
  return kind == nullptr || kind->is_spoken_of;
}

}  // namespace

Expected<void> InstanceOptions::validate() const {
  if (!(min_score >= 0 && min_score <= 1)) {
    return fail("min_score is {}; expected a probability, 0 to 1", min_score);
  }
  if (!(max_range_m > 0 && std::isfinite(max_range_m))) {
    return fail("max_range_m is {}; expected more than 0 m", max_range_m);
  }
  if (min_observations < 1) {
    return fail("min_observations is {}; expected at least 1 key-frame", min_observations);
  }
  if (min_probability && !(*min_probability >= 0 && *min_probability <= 1)) {
    return fail("min_probability is {}; expected a probability, 0 to 1", *min_probability);
  }
  return {};
}

WeighedCandidates weigh_candidates(std::span<const ObservedKeyframe> keyframes,
                                   const GroundPlane& level, const InstanceOptions& options) {
  WeighedCandidates weighed;
  weighed.observations = world_observations(keyframes, level, options);
  weighed.candidates = find_candidates(weighed.observations, keyframes, level);
  for (const Candidate& candidate : weighed.candidates) {
    weighed.visibility.push_back(
        visibility_of(candidate, weighed.observations, keyframes, options.max_range_m));
  }
  weighed.evidence =
      evidence_of(weighed.candidates, weighed.visibility, weighed.observations, level);
  return weighed;
}

std::vector<Instance> believed_instances(const WeighedCandidates& weighed,
                                         std::span<const ObservedKeyframe> keyframes,
                                         const InstanceModel& model,
                                         const InstanceOptions& options) {
  const double min_probability = options.min_probability.value_or(model.min_probability);
  std::vector<Hypothesis> hypotheses;
  for (std::size_t i = 0; i < weighed.candidates.size(); ++i) {
    const Candidate& candidate = weighed.candidates[i];
    hypotheses.push_back({&candidate, weighed.visibility[i],
                          model.probability(weighed.evidence[i], candidate.class_name)});
  }
  std::vector<Instance> instances;
  for (const Thing& thing : each_once(std::move(hypotheses))) {
    if (thing.hypothesis.probability < min_probability ||
        !is_spoken_of(thing.hypothesis.candidate->class_name)) {
      continue;
    }
    Instance instance = instance_of(thing, weighed.observations, keyframes, model);
    if (instance.observations >= options.min_observations) {
      instances.push_back(std::move(instance));
    }
  }
  std::ranges::sort(instances, {}, [](const Instance& one) {
    return std::tuple(one.name, one.keyframe_id, one.picture_box.left, one.picture_box.top);
  });
  return instances;
}

std::vector<Instance> find_instances(std::span<const ObservedKeyframe> keyframes,
                                     const GroundPlane& level, const InstanceOptions& options) {
  return believed_instances(weigh_candidates(keyframes, level, options), keyframes,
                            InstanceModel::built_in(), options);
}

}  // namespace roomwise::objects
