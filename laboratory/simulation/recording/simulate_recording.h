#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/sensor/sensor.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// A walk with a camera through a made-up home. The same options give the same recording, byte for
// byte, at any number of threads.
struct SimulationOptions {
  // Whose home; absent: the reference flat.
  std::optional<HomeOptions> home;
  Scenario scenario = Scenario::kDay;
  std::uint64_t scenario_seed = 0;  // of what is moved
  bool bare_halls = false;          // see with_bare_halls()
  WalkOptions walk;
  geometry::PinholeCamera camera = default_camera();
  RenderOptions render;
  SensorOptions sensor;

  // 640x480, 63 degrees wide, without distortion; 5000 depth units a metre.
  [[nodiscard]] static geometry::PinholeCamera default_camera();
  [[nodiscard]] Expected<void> validate() const;
};

struct SimulationSummary {
  std::uint64_t frames = 0;
  double seconds = 0;  // of the walk
  std::size_t rooms = 0;
  std::size_t objects = 0;
  BakeStatistics bake;
  bool finished = false;  // false: interrupted; the recording holds the frames before
};

// The home that the options describe, at their time of day.
[[nodiscard]] Expected<HomeModel> make_home(const SimulationOptions& options,
                                            const FurnitureCatalogue& catalogue);

// Writes the recording in TUM's layout: rgb/, depth/, rgb.txt, depth.txt, camera.txt,
// groundtruth.txt, rooms.txt, and what only a made-up home can tell: objects.json (every thing, its
// box, in which frames it is seen), floorplan.json (walls, doors, free space), simulation.json (of
// what it is made), credits.txt (who made the furniture). The folder must be empty, not exist,
// or hold an unfinished recording of the same options, which is begun anew. When the user
// interrupts, what was drawn is kept with its truth; before the first frame nothing is left behind.
[[nodiscard]] Expected<SimulationSummary> simulate_recording(const SimulationOptions& options,
                                                             const FurnitureCatalogue& catalogue,
                                                             const std::filesystem::path& folder,
                                                             ThreadPool& pool, Progress& progress,
                                                             StageClock& clock);

}  // namespace roomwise::simulation
