#pragma once

#include <map>
#include <string>
#include <string_view>

#include "roomwise/objects/instances/evidence.h"
#include "roomwise/objects/instances/middle_variance.h"

namespace roomwise::objects {

// How probable it is that a candidate is there and is called so: a logistic regression on its
// evidence, with an intercept for each kind (shrunk, since few kinds were seen often); and how far
// its middle may be off: a variance that is a sum of what may cause it. Its numbers are those of
// instance_model.json, which roomwise-lab fit-instances writes; where they come from stands
// there.
struct InstanceModel {
  double bias = 0;
  Evidence weights{};
  std::map<std::string, double, std::less<>> bias_of_kind;  // more than `bias`; absent: 0
  double min_probability = 0.5;                             // of what is told
  VarianceTerms variance_weights{};                         // 0 or more

  [[nodiscard]] double probability(const Evidence& evidence, std::string_view kind) const;

  // The standard deviation of a candidate's middle along the axes of its box, m.
  [[nodiscard]] Eigen::Vector3d sigma_m(const Candidate& candidate) const;

  // Fails, naming the field, where one is missing (but a single weight, which then is 0), of
  // another type or not finite, or evidence or a term of the variance is named that this program
  // does not know.
  [[nodiscard]] static Expected<InstanceModel> parse(std::string_view json);
  // That of instance_model.json, which is compiled in.
  [[nodiscard]] static const InstanceModel& built_in();
};

// What find_instances() weighs: candidates and what speaks for each. Hangs on no model.
struct WeighedCandidates {
  std::vector<WorldObservation> observations;
  std::vector<Candidate> candidates;
  std::vector<Visibility> visibility;
  std::vector<Evidence> evidence;
};
[[nodiscard]] WeighedCandidates weigh_candidates(std::span<const ObservedKeyframe> keyframes,
                                                 const GroundPlane& level,
                                                 const InstanceOptions& options);
// Those that the model believes; of what shares its space the most probable. By name, then by
// key-frame.
[[nodiscard]] std::vector<Instance> believed_instances(const WeighedCandidates& weighed,
                                                       std::span<const ObservedKeyframe> keyframes,
                                                       const InstanceModel& model,
                                                       const InstanceOptions& options);

}  // namespace roomwise::objects
