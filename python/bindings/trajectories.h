#pragma once

#include "python/bindings/arrays.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::python {

// A trajectory as Python holds it.
struct Trajectory {
  recording::Trajectory poses;
};

}  // namespace roomwise::python
