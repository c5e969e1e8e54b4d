#include "roomwise/objects/instances/instance_model.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "roomwise/base/own_data.h"
#include "roomwise/objects/built_in_data.h"

namespace roomwise::objects {
namespace {

// The numbers that an object of JSON has under the names; 0 where it has none.
template <std::size_t kCount>
Expected<std::array<double, kCount>> named_numbers(
    const nlohmann::json& object, const std::array<std::string_view, kCount>& names,
    std::string_view what) {
  std::array<double, kCount> numbers{};
  for (const auto& [name, number] : object.items()) {
    const auto place = std::ranges::find(names, name);
    if (place == names.end()) {
      return fail("a weight is given for \"{}\", which is no {}", name, what);
    }
    number.get_to(numbers[static_cast<std::size_t>(place - names.begin())]);
  }
  return numbers;
}

}  // namespace

double InstanceModel::probability(const Evidence& evidence, std::string_view kind) const {
  double log_odds = bias;
  for (std::size_t i = 0; i < evidence.size(); ++i) log_odds += weights[i] * evidence[i];
  if (const auto own = bias_of_kind.find(kind); own != bias_of_kind.end()) log_odds += own->second;
  return 1 / (1 + std::exp(-log_odds));
}

Eigen::Vector3d InstanceModel::sigma_m(const Candidate& candidate) const {
  const auto terms = variance_terms(candidate);
  Eigen::Vector3d sigma_m;
  for (int axis = 0; axis < 3; ++axis) {
    const VarianceTerms& along = terms[static_cast<std::size_t>(axis)];
    sigma_m[axis] =
        std::sqrt(std::inner_product(along.begin(), along.end(), variance_weights.begin(), 0.0));
  }
  return sigma_m;
}

Expected<InstanceModel> InstanceModel::parse(std::string_view json) {
  InstanceModel model;
  try {
    const auto parsed = nlohmann::json::parse(json);
    parsed.at("bias").get_to(model.bias);
    parsed.at("min_probability").get_to(model.min_probability);
    model.bias_of_kind = parsed.at("of_kind").get<decltype(model.bias_of_kind)>();
    ROOMWISE_TRY(model.weights, named_numbers(parsed.at("weights"), kEvidenceNames, "evidence"));
    ROOMWISE_TRY(model.variance_weights,
                 named_numbers(parsed.at("variance"), kVarianceNames, "term of the variance"));
  } catch (const nlohmann::json::exception& error) {
    return fail("the model of instances: {}", error.what());
  }
  const bool is_finite =
      std::isfinite(model.bias) &&
      std::ranges::all_of(model.weights, [](double weight) { return std::isfinite(weight); });
  if (!is_finite || !(model.min_probability >= 0 && model.min_probability <= 1)) {
    return fail("the model of instances: a number is not finite, or min_probability not in [0, 1]");
  }
  const bool is_variance = std::ranges::all_of(
      model.variance_weights, [](double weight) { return weight >= 0 && std::isfinite(weight); });
  if (!is_variance) return fail("the model of instances: a weight of the variance is negative");
  return model;
}

const InstanceModel& InstanceModel::built_in() {
  static const InstanceModel kModel = own_data(parse(kInstanceModelJson));
  return kModel;
}

}  // namespace roomwise::objects
