#include "roomwise/objects/instances/instance_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "roomwise/objects/built_in_data.h"

namespace roomwise::objects {

double InstanceModel::probability(const Evidence& evidence, std::string_view kind) const {
  double log_odds = bias;
  for (std::size_t i = 0; i < evidence.size(); ++i) log_odds += weights[i] * evidence[i];
  if (const auto own = bias_of_kind.find(kind); own != bias_of_kind.end()) log_odds += own->second;
  return 1 / (1 + std::exp(-log_odds));
}

Expected<InstanceModel> InstanceModel::parse(std::string_view json) {
  InstanceModel model;
  try {
    const auto parsed = nlohmann::json::parse(json);
    parsed.at("bias").get_to(model.bias);
    parsed.at("min_probability").get_to(model.min_probability);
    model.bias_of_kind = parsed.at("of_kind").get<decltype(model.bias_of_kind)>();
    for (const auto& [name, weight] : parsed.at("weights").items()) {
      const auto place = std::ranges::find(kEvidenceNames, name);
      if (place == kEvidenceNames.end()) {
        return fail("a weight is given for \"{}\", which is no evidence", name);
      }
      weight.get_to(model.weights[static_cast<std::size_t>(place - kEvidenceNames.begin())]);
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("the model of instances: {}", error.what());
  }
  const bool is_finite =
      std::isfinite(model.bias) &&
      std::ranges::all_of(model.weights, [](double weight) { return std::isfinite(weight); });
  if (!is_finite || !(model.min_probability >= 0 && model.min_probability <= 1)) {
    return fail("the model of instances: a number is not finite, or min_probability not in [0, 1]");
  }
  return model;
}

const InstanceModel& InstanceModel::built_in() {
  static const InstanceModel kModel = [] {
    auto model = parse(kInstanceModelJson);
    if (!model) std::abort();  // the program's own data, which a test reads
    return *std::move(model);
  }();
  return kModel;
}

}  // namespace roomwise::objects
