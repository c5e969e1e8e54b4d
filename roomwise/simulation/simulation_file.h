#pragma once

#include <filesystem>

#include "roomwise/simulation/simulate_recording.h"

namespace roomwise::simulation {

// simulation.json: of what a simulated recording is made, all that simulate_recording() needs to
// make it again. Fields as in SimulationOptions and the structs in it.
[[nodiscard]] Expected<void> write_simulation(const std::filesystem::path& path,
                                              const SimulationOptions& options);
// Fails, naming the file and the field, where it is not such a file.
[[nodiscard]] Expected<SimulationOptions> read_simulation(const std::filesystem::path& path);

// Whether the folder holds a finished recording that these options give. Where light is cached
// makes no difference.
[[nodiscard]] bool is_made_with(const std::filesystem::path& folder,
                                const SimulationOptions& options);

}  // namespace roomwise::simulation
