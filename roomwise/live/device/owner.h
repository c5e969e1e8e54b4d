#pragma once

#include <string>

#include "roomwise/service/credentials/identity.h"

namespace roomwise::live {

// By whom a thing was taught or a place marked, as the home keeps it: the device's number, which is
// never given twice. Its name can change.
[[nodiscard]] inline std::string owner_of(const service::Identity& who) {
  return std::to_string(who.device);
}

}  // namespace roomwise::live
