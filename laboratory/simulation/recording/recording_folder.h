#pragma once

#include <filesystem>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/recording/simulate_recording.h"

// What lies in the folder that a simulated recording is to be written to. While it is being made
// it holds unfinished.json, so that one that was broken off is known for what it is.
namespace roomwise::simulation {

// Whether the folder holds the finished recording of these options. Fails where the program that
// made it, or its furniture, made another home of them than this one does.
[[nodiscard]] Expected<bool> is_made_already(const std::filesystem::path& folder,
                                             const SimulationOptions& options,
                                             const FurnitureCatalogue& catalogue);

// Removes an unfinished recording of these options, or one without a frame, and nothing else. Fails
// where it holds frames of other options; leaves all other folders as they are.
[[nodiscard]] Expected<void> remove_unfinished(const std::filesystem::path& folder,
                                               const SimulationOptions& options);
[[nodiscard]] Expected<void> mark_unfinished(const std::filesystem::path& folder,
                                             const SimulationOptions& options);
// Writes simulation.json, which stands for a recording that is whole.
[[nodiscard]] Expected<void> mark_finished(const std::filesystem::path& folder,
                                           const SimulationOptions& options,
                                           const std::string& scene_digest);

}  // namespace roomwise::simulation
