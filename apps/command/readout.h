#pragma once

#include <optional>

#include "command.h"

// How commands tell the readout time of a rolling shutter, which is not known where no frame is
// near enough in time to another.
namespace roomwise::app {

inline std::string readout_text(std::optional<double> readout_s) {
  return readout_s ? fmt::format("{:.1f} ms", 1000 * *readout_s) : "not known";
}

inline Json readout_json(std::optional<double> readout_s) {
  return readout_s ? Json(*readout_s) : Json();
}

}  // namespace roomwise::app
