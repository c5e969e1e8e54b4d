#pragma once

#include <filesystem>
#include <string>

#include "laboratory/simulation/recording/simulate_recording.h"

namespace roomwise::simulation {

// Of what a simulated recording is made.
struct MadeRecording {
  SimulationOptions options;
  // Of the home as the program made it (scene_digest()): a program that has changed since makes
  // another one of the same options. Empty in a recording that is not finished.
  std::string scene_sha256;
};

// simulation.json: fields as in SimulationOptions and the structs in it.
[[nodiscard]] Expected<void> write_simulation(const std::filesystem::path& path,
                                              const MadeRecording& made);
// Fails, naming the file and the field, where it is not such a file.
[[nodiscard]] Expected<MadeRecording> read_simulation(const std::filesystem::path& path);

// Whether two walks are the same. Where light is cached makes no difference.
[[nodiscard]] bool are_alike(const SimulationOptions& a, const SimulationOptions& b);

}  // namespace roomwise::simulation
