#include "roomwise/objects/instances/instances.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include "roomwise/objects/instances/class_size_prior.h"
#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {
namespace {

const std::string& best_class(const Candidate& candidate) {
  return std::ranges::max_element(candidate.scores, {}, [](const auto& one) { return one.second; })
      ->first;
}

// The share of a box that lies in another, by a grid of its points.
double share_inside(const geometry::OrientedBox& box, const geometry::OrientedBox& of) {
  constexpr int kSteps = 6;  // a side
  int inside = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Vector3d step(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps));
    const Eigen::Vector3d place =
        box.size_m.cwiseProduct((step.array() + 0.5).matrix() / kSteps) - box.size_m / 2;
    if (of.distance_m(box.world_from_box * place) == 0) ++inside;
  }
  return static_cast<double>(inside) / (kSteps * kSteps * kSteps);
}

// How much two candidates are one thing, [0, 1]: the share of the cells of both that both have or,
// where the boxes are of like size, of the smaller one's, since few pictures show only a part. Two
// things of one name cannot fill the same space, so there the share of either box counts, too.
double overlap(const Candidate& a, const Candidate& b) {
  constexpr double kLikeSize = 0.35;  // of the volumes
  std::vector<VoxelKey> both;
  std::ranges::set_intersection(a.voxels, b.voxels, std::back_inserter(both));
  const auto shared = static_cast<double>(both.size());
  const auto [smaller, larger] =
      std::minmax({static_cast<double>(a.voxels.size()), static_cast<double>(b.voxels.size())});
  const double volume_a = a.box_world.size_m.prod(), volume_b = b.box_world.size_m.prod();
  const bool are_alike = std::min(volume_a, volume_b) >= kLikeSize * std::max(volume_a, volume_b);
  const double of = are_alike ? smaller : smaller + larger - shared;
  const double of_cells = shared / std::max(1.0, of);
  if (best_class(a) != best_class(b)) return of_cells;
  return std::max(
      {of_cells, share_inside(a.box_world, b.box_world), share_inside(b.box_world, a.box_world)});
}

bool fits(const Candidate& candidate, const std::string& name) {
  return size_prior_of(name).holds(candidate.box_world.size_m);
}

// Whether two candidates of one name that share their space are two things all the same: one of
// them is as large as such things are, and both together are larger than any. So two chairs whose
// pictures were taken for those of one do not swallow the one of them that was measured.
bool are_two(const Candidate& a, const Candidate& b, const Candidate& joined) {
  const std::string &name = best_class(a), &whole = best_class(joined);
  return name == best_class(b) && joined.has_extent() &&
         size_prior_of(whole).is_smaller_than(joined.box_world.size_m) &&
         (fits(a, name) || fits(b, name));
}

// One thing that is called by several names: groups of different names that fill the same space.
// The ones that share most are joined first.
void join_names(std::vector<Candidate>& candidates, std::span<const WorldObservation> observations,
                std::span<const ObservedKeyframe> keyframes, const GroundPlane& level) {
  constexpr double kSameThing = 0.4;
  std::set<std::pair<std::size_t, std::size_t>> apart;  // by their first observations
  const auto pair_of = [](const Candidate& a, const Candidate& b) {
    return std::pair(std::min(a.group.front(), b.group.front()),
                     std::max(a.group.front(), b.group.front()));
  };
  while (true) {
    double most = kSameThing;
    std::pair<std::size_t, std::size_t> best;
    for (std::size_t a = 0; a < candidates.size(); ++a) {
      for (std::size_t b = a + 1; b < candidates.size(); ++b) {
        if (apart.contains(pair_of(candidates[a], candidates[b]))) continue;
        const double shared = overlap(candidates[a], candidates[b]);
        if (shared <= most) continue;
        most = shared;
        best = {a, b};
      }
    }
    if (best.second == 0) return;
    Candidate& first = candidates[best.first];
    Candidate& second = candidates[best.second];
    ObservationCluster group = first.group;
    group.insert(group.end(), second.group.begin(), second.group.end());
    std::ranges::sort(group);
    Candidate joined = candidate_of(std::move(group), observations, keyframes, level);
    if (are_two(first, second, joined)) {
      apart.insert(pair_of(first, second));
      continue;
    }
    // Of observations that hold too little in common, the thing is what most of them show.
    if (joined.has_extent()) {
      first = std::move(joined);
    } else if (second.group.size() > first.group.size()) {
      std::swap(first, second);
    }
    candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(best.second));
  }
}

double logistic(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

// How strongly a candidate is believed to be there, by the key-frames that saw it and those that
// should have.
struct Existence {
  int observations = 0, missed = 0;
  double probability = 0;
};

// What a key-frame's best observation says for a thing, as log odds. The score of a box says how
// sure it is, a detector's and that of a classifier which is shown the box alone. Classifiers are
// often sure of what is not there, but not from all sides: that they say nothing of a box counts
// more, and what activation maps say or do not say only a little each time. That a proposal stands
// there depth says, and what its best views do not say of it is in its score: it is not missed
// elsewhere.
struct Evidence {
  static constexpr double kPriorLogOdds = -2.5;
  static constexpr double kActivation = 0.45;

  static double log_odds_of_miss(DetectionSource source) {
    switch (source) {
      case DetectionSource::kDetector:
        return -0.15;
      case DetectionSource::kCrop:
        return -0.75;
      case DetectionSource::kActivation:
        return -0.2;
      case DetectionSource::kProposal:  // is never missed, see existence_of()
        break;
    }
    return 0;
  }

  static double of_box(double score) {
    const double safe = std::clamp(score, 0.05, 0.95);
    return std::max(0.2, 1 + std::log(safe / (1 - safe)));
  }
};

Existence existence_of(const Candidate& candidate, std::span<const WorldObservation> observations,
                       std::span<const ObservedKeyframe> keyframes, double max_range_m) {
  std::map<std::size_t, double> speaks_for;  // by key-frame
  for (const std::size_t index : candidate.group) {
    const WorldObservation& observation = observations[index];
    double& most = speaks_for[observation.keyframe];
    most =
        std::max(most, observation.detection->source == DetectionSource::kActivation
                           ? Evidence::kActivation
                           : Evidence::of_box(static_cast<double>(observation.detection->score)));
  }
  Existence existence{.observations = static_cast<int>(speaks_for.size())};
  const bool stands_apart = std::ranges::any_of(candidate.group, [&](std::size_t index) {
    return observations[index].detection->source == DetectionSource::kProposal;
  });
  for (std::size_t k = 0; k < keyframes.size() && !stands_apart; ++k) {
    if (speaks_for.contains(k) || keyframes[k].sources_not_run.contains(candidate.source)) continue;
    if (should_see(keyframes[k], candidate.surface_world, max_range_m)) ++existence.missed;
  }
  double log_odds =
      Evidence::kPriorLogOdds + existence.missed * Evidence::log_odds_of_miss(candidate.source);
  for (const auto& [keyframe, evidence] : speaks_for) log_odds += evidence;
  existence.probability = logistic(log_odds);
  return existence;
}

// What classifiers alone say must stand by itself, and look as such things do, before it is
// anything or may name what a detector found.
bool may_be_there(const Candidate& candidate, std::span<const WorldObservation> observations,
                  std::span<const ObservedKeyframe> keyframes, const InstanceOptions& options) {
  if (candidate.source == DetectionSource::kDetector) return true;
  // Of a proposal the whole was measured before it got its name.
  return (candidate.source == DetectionSource::kProposal || candidate.fits_size_prior) &&
         existence_of(candidate, observations, keyframes, options.max_range_m).probability >=
             options.min_probability;
}

// Or is larger by no more than some of what it touches, which stays with it.
bool nearly_fits(const Candidate& candidate, const std::string& name) {
  const ClassSizePrior shape = size_prior_of(name);
  return shape.on_floor && shape.holds(ClassSizePrior::without_rim(candidate.box_world.size_m));
}

// A vessel that stands on something and is thicker than bottles are: detectors call vases bottles.
bool is_thick_vessel(const Candidate& candidate) {
  constexpr double kThickest_m = 0.35, kHighest_m = 0.5;
  constexpr double kOnFloor_m = 0.3;  // bins are called bottles, too
  const Eigen::Vector3d& size_m = candidate.box_world.size_m;
  return candidate.foot_m > kOnFloor_m &&
         size_m.head<2>().minCoeff() > size_prior_of("bottle").max_side_m &&
         size_m.head<2>().maxCoeff() <= kThickest_m && size_m.z() <= kHighest_m;
}

// What it is called, with the shares of the scores. Names of things that are never or seldom of
// that size were mistakes, and so perhaps were the others: a little of their share stays with them.
std::map<std::string, double> shares_of_names(const Candidate& candidate) {
  constexpr double kMistaken = 0.15;
  std::map<std::string, double> shares = candidate.scores;
  // The name that was a mistake stays with its little share: by it the thing's regions are known.
  if (shares.contains("bottle") && is_thick_vessel(candidate)) shares["vase"] += shares["bottle"];
  double sum = 0;
  for (auto& [name, score] : shares) {
    const bool is_usual = size_prior_of(name).is_usual(candidate.box_world.size_m);
    if (!is_usual || !fits(candidate, name)) score *= kMistaken;
    sum += score;
  }
  for (auto& [name, score] : shares) score /= sum;
  return shares;
}

// The name with the largest share of those that fit; where none does, of those that nearly do.
// Empty where none is left.
std::string name_that_fits(const Candidate& candidate,
                           const std::map<std::string, double>& shares) {
  for (const auto& may_be : {fits, nearly_fits}) {
    double most = 0;
    std::string best;
    for (const auto& [name, share] : shares) {
      if (share <= most || !may_be(candidate, name)) continue;
      most = share;
      best = name;
    }
    if (!best.empty()) return best;
  }
  return {};
}

// Nothing where no name fits.
std::optional<Instance> instance_of(const Candidate& candidate,
                                    std::span<const WorldObservation> observations,
                                    std::span<const ObservedKeyframe> keyframes,
                                    const InstanceOptions& options) {
  Instance instance;
  instance.names = shares_of_names(candidate);
  instance.name = name_that_fits(candidate, instance.names);
  if (instance.name.empty()) return std::nullopt;
  const WorldObservation* best = nullptr;
  for (const std::size_t index : candidate.group) {
    const WorldObservation& observation = observations[index];
    // Where only a classifier calls it so, the best observation shows it all the same.
    const auto says_so = [&](const WorldObservation& one) {
      const std::string& name = one.detection->class_name;
      return name == instance.name ||
             (instance.name == "vase" && name == "bottle" && is_thick_vessel(candidate));
    };
    if (best == nullptr || (says_so(observation) && !says_so(*best))) best = &observation;
  }
  const Existence existence = existence_of(candidate, observations, keyframes, options.max_range_m);
  instance.observations = existence.observations;
  instance.expected = existence.observations + existence.missed;
  instance.probability = existence.probability * instance.names[instance.name];
  const ObservedKeyframe& keyframe = keyframes[best->keyframe];
  instance.keyframe_id = keyframe.keyframe_id;
  instance.picture_box = best->detection->box;
  instance.box_keyframe = {
      keyframe.world_from_camera.inverse() * candidate.box_world.world_from_box,
      candidate.box_world.size_m};
  instance.sigma_m = candidate.sigma_m;
  return instance;
}

double min_probability(const std::string& name, const InstanceOptions& options) {
  const auto more = options.min_probability_of.find(name);
  return more == options.min_probability_of.end() ? options.min_probability
                                                  : std::max(more->second, options.min_probability);
}

// Whether they lie above each other, and both together are no higher than a lamp is. A shade may
// hang on an arm.
bool may_be_one_lamp(const geometry::OrientedBox& a, const geometry::OrientedBox& b,
                     const GroundPlane& level) {
  constexpr double kAside_m = 0.3, kArm_m = 0.45;
  const Eigen::Vector3d apart = a.center() - b.center();
  const double above_m = apart.dot(level.up_world);
  const double half_heights_m = (a.size_m.z() + b.size_m.z()) / 2;
  const bool is_higher = std::abs(above_m) >= half_heights_m;
  return (apart - above_m * level.up_world).norm() <= (is_higher ? kArm_m : kAside_m) &&
         std::abs(above_m) + half_heights_m <= size_prior_of("lamp").max_height_m;
}

// A plant's pot is often called a vase.
bool is_pot(const Candidate& thing, std::span<const Candidate> things) {
  constexpr double kReach_m = 0.05;
  return thing.instance.name == "vase" && std::ranges::any_of(things, [&](const Candidate& other) {
           return other.instance.name == "plant" &&
                  other.box_world.distance_m(thing.box_world.center()) <= kReach_m;
         });
}

// What stands on the floor does not stand in a bed: its head, or its foot, from one side.
bool is_part_of_bed(const Candidate& thing, const Candidate& surer) {
  constexpr double kInside = 0.5;
  return surer.instance.name == "bed" && thing.instance.name != "bed" &&
         size_prior_of(thing.instance.name).on_floor &&
         share_inside(thing.box_world, surer.box_world) >= kInside;
}

// Two things of one name do not stand in each other: what reaches into a surer one is what another
// picture shows of it. A classifier that is shown what stands beside a thing sees the thing, too: a
// lamp in the box of its nightstand. Of a floor lamp some pictures show the shade and others the
// foot. And few have two microwaves beside each other: ovens and hoods are called so in some of the
// pictures.
bool is_the_same(const Candidate& thing, const Candidate& surer, const GroundPlane& level) {
  constexpr double kShown_m = 0.25;
  constexpr double kReachesInto = 0.2;  // of either box; boxes of neighbours err by some
  if (thing.instance.name != surer.instance.name) return false;
  const geometry::OrientedBox &box = thing.box_world, &other = surer.box_world;
  if (share_inside(box, other) >= kReachesInto || share_inside(other, box) >= kReachesInto) {
    return true;
  }
  if (thing.instance.name == "lamp" && may_be_one_lamp(box, other, level)) return true;
  const double apart_m = std::min(other.distance_m(box.center()), box.distance_m(other.center()));
  return (2 * thing.instance.observations <= surer.instance.observations &&
          apart_m < size_prior_of(thing.instance.name).min_apart_m) ||
         (thing.source != DetectionSource::kDetector && apart_m <= kShown_m);
}

// The things without those that are, or are a part of, another one, which is surer.
std::vector<Candidate> each_once(std::vector<Candidate> things, const GroundPlane& level) {
  std::ranges::stable_sort(things, std::ranges::greater(), [](const Candidate& one) {
    return std::tuple(fits(one, one.instance.name), one.source == DetectionSource::kDetector,
                      one.instance.observations, one.instance.probability);
  });
  std::vector<Candidate> kept;
  for (const Candidate& thing : things) {
    const bool is_there = std::ranges::any_of(kept, [&](const Candidate& surer) {
      return is_the_same(thing, surer, level) || is_part_of_bed(thing, surer);
    });
    if (!is_there && !is_pot(thing, things)) kept.push_back(thing);
  }
  return kept;
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
  if (!(min_probability >= 0 && min_probability <= 1)) {
    return fail("min_probability is {}; expected a probability, 0 to 1", min_probability);
  }
  for (const auto& [name, least] : min_probability_of) {
    if (least >= 0 && least <= 1) continue;
    return fail("min_probability_of \"{}\" is {}; expected a probability, 0 to 1", name, least);
  }
  return {};
}

std::vector<Instance> find_instances(std::span<const ObservedKeyframe> keyframes,
                                     const GroundPlane& level, const InstanceOptions& options) {
  const std::vector<WorldObservation> observations = world_observations(keyframes, level, options);
  std::vector<Candidate> candidates;
  for (ObservationCluster& group : cluster_observations(observations)) {
    if (group.size() < 2) continue;
    Candidate candidate = candidate_of(std::move(group), observations, keyframes, level);
    if (candidate.has_extent() && may_be_there(candidate, observations, keyframes, options))
      candidates.push_back(std::move(candidate));
  }
  join_names(candidates, observations, keyframes, level);
  // Look-alikes, unless somebody calls other things so.
  std::set<std::string> look_alikes, classes;
  for (const WorldObservation& observation : observations) {
    const Detection& detection = *observation.detection;
    (detection.is_in_vocabulary ? classes : look_alikes).insert(detection.class_name);
  }
  std::vector<Candidate> things;
  for (Candidate& candidate : candidates) {
    auto instance = instance_of(candidate, observations, keyframes, options);
    if (!instance || (look_alikes.contains(instance->name) && !classes.contains(instance->name)) ||
        instance->observations < options.min_observations ||
        instance->probability < min_probability(instance->name, options)) {
      continue;
    }
    candidate.instance = *std::move(instance);
    things.push_back(std::move(candidate));
  }
  std::vector<Instance> instances;
  for (Candidate& thing : each_once(std::move(things), level)) {
    instances.push_back(std::move(thing.instance));
  }
  std::ranges::sort(instances, {}, [](const Instance& one) {
    return std::tuple(one.name, one.keyframe_id, one.picture_box.left, one.picture_box.top);
  });
  return instances;
}

}  // namespace roomwise::objects
