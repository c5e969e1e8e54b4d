#pragma once

#include <string>

#include "roomwise/home/home.h"

namespace roomwise::pipeline {

// What of a home decides how networks look at its pictures: where it is the same for two homes,
// in_precision() gives the same networks for both, which can then be loaded once. Not for people.
[[nodiscard]] Expected<std::string> network_precision_key(const home::Home& home);

}  // namespace roomwise::pipeline
