#pragma once

#include <filesystem>

#include "roomwise/evaluation/cloud_error.h"
#include "roomwise/evaluation/object_error.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

// A home against the truth of the simulated recording that it was mapped from.
namespace roomwise::pipeline {

// The map has a world of its own: this moves it onto that of the recording's groundtruth.txt as its
// trajectory fits best.
[[nodiscard]] Expected<geometry::RigidTransform> truth_from_map(
    const home::Home& home, const std::filesystem::path& recording);

struct ObjectEvaluation {
  std::vector<evaluation::TrueObject> truth;   // what the home can name and the walk showed
  std::vector<evaluation::FoundObject> found;  // in the truth's frame
  evaluation::ObjectErrors errors;
  std::size_t without_place = 0;  // found, but where is not known
};

// Objects of the home against objects.json: a thing counts as found within `most_distance_m` of its
// box. Things that the walk never showed are left out.
[[nodiscard]] Expected<ObjectEvaluation> evaluate_objects(const home::Home& home,
                                                          const std::filesystem::path& recording,
                                                          double most_distance_m);

// The map's points against the surfaces of the home that simulation.json describes. Furniture is
// read from the folder of its archives.
[[nodiscard]] Expected<evaluation::CloudError> evaluate_map(const home::Home& home,
                                                            const std::filesystem::path& recording,
                                                            const std::filesystem::path& furniture,
                                                            double voxel_size_m, RunContext& run);

}  // namespace roomwise::pipeline
