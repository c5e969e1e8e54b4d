#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/network/formats/network_file.h"

namespace roomwise::network {

// The names of what is read of a network that looks at whole pictures: of the features, then of the
// scores.
struct ClassifierOutputs {
  std::vector<std::string> features;
  std::optional<std::string> scores;

  [[nodiscard]] std::vector<std::string> all() const;
};

// As the card says, or the network's only output. Fails where it has several and the card names
// none.
[[nodiscard]] Expected<ClassifierOutputs> classifier_outputs(const NetworkFile& file);

// Classifier::preprocessing() of a network that is used so.
[[nodiscard]] std::string preprocessing_of(const ModelCard& card, const ClassifierOutputs& outputs);

}  // namespace roomwise::network
