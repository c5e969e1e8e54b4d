#pragma once

#include <filesystem>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/walk/home_views.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// Pictures of the furniture and the rooms of many made-up homes. The same options give the same
// pictures, byte for byte, at any number of threads.
struct ViewsOptions {
  std::uint64_t first_home = 1, last_home = 10;  // their seeds
  std::vector<RoomKind> rooms;                   // of every home, as in HomeOptions
  std::uint64_t seed = 0;                        // of scenarios, views and the sensor
  HomeViewOptions views;
  RenderOptions render{.samples_per_pixel = 2, .bake_effort = 0.2, .light_cache = {}};
  int jpeg_quality = 92;

  [[nodiscard]] Expected<void> validate() const;
};

struct ViewsSummary {
  std::uint64_t homes = 0;     // that the folder holds
  std::uint64_t pictures = 0;  // likewise
  bool finished = false;       // false: interrupted; the same options go on
};

// The scenario of a home, drawn by the seed: of six homes two by day.
[[nodiscard]] Scenario scenario_of(std::uint64_t home_seed, std::uint64_t seed);

// Writes a folder a class (SampledView::shows) of JPEGs as the sensor gives them, views.json (of
// what they are made, and each home's scenario and number of pictures) and credits.txt (who made
// the furniture). Goes on where the folder holds homes of the same options, which may name a later
// last home; fails where it holds anything else.
[[nodiscard]] Expected<ViewsSummary> simulate_views(const ViewsOptions& options,
                                                    const FurnitureCatalogue& catalogue,
                                                    const std::filesystem::path& folder,
                                                    ThreadPool& pool, Progress& progress);

}  // namespace roomwise::simulation
