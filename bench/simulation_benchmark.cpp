// What drawing a simulated home costs: the bake of its light, and frames of a walk through it,
// beside Embree's bare rate on the same scene:
//   simulation_benchmark [RUNS]        default: 3
// The reference flat by day, 640x480, all threads. Processor time is that of all threads.

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "arguments.h"
#include "laboratory/simulation/recording/simulate_recording.h"
#include "roomwise/base/stage_clock.h"

namespace {

using namespace roomwise;
using simulation::Renderer;

// "median (least to most)".
std::string spread(std::vector<double> values, int digits) {
  std::ranges::sort(values);
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", values[values.size() / 2], digits,
                     values.front(), digits, values.back(), digits);
}

struct Figures {
  std::vector<double> bake_cpu_s, bake_rays_per_s, bare_rays_per_s;
  std::vector<double> frame_cpu_s[2];  // with 2 and 4 samples a pixel
};

// Every 20th pose of the walk.
constexpr std::size_t kStep = 20;
constexpr int kSamples[2] = {2, 4};

Expected<void> measure(Figures& figures) {
  simulation::SimulationOptions options;
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open());
  ROOMWISE_TRY(const auto home, simulation::make_home(options, catalogue));
  ROOMWISE_TRY(const auto walk, simulation::plan_walk(home, options.walk));
  ThreadPool pool(ThreadPool::default_size());
  SilentProgress silent;
  for (std::size_t k = 0; k < std::size(kSamples); ++k) {
    options.render.samples_per_pixel = kSamples[k];
    ROOMWISE_TRY(const auto renderer,
                 Renderer::create(home, catalogue, options.render, pool, silent));
    const simulation::BakeStatistics& bake = renderer->bake_statistics();
    figures.bake_cpu_s.push_back(bake.cpu_s);
    figures.bake_rays_per_s.push_back(static_cast<double>(bake.rays) / bake.cpu_s / 1e6);
    double frames = 0, rays = 0, frame_cpu_s = 0, bare_cpu_s = 0;
    for (std::size_t i = 0; i < walk.size(); i += kStep, ++frames) {
      const double start_s = process_cpu_time_s();
      (void)renderer->render(options.camera, walk[i].world_from_camera, pool);
      const double drawn_s = process_cpu_time_s();
      (void)renderer->trace_bare(options.camera, walk[i].world_from_camera);
      bare_cpu_s += process_cpu_time_s() - drawn_s;
      frame_cpu_s += drawn_s - start_s;
      rays += options.camera.width * options.camera.height;
    }
    figures.frame_cpu_s[k].push_back(frame_cpu_s / frames);
    figures.bare_rays_per_s.push_back(rays / bare_cpu_s / 1e6);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  const auto runs = bench::only_count(argc, argv, 3, "simulation_benchmark [RUNS]");
  if (!runs) {
    fmt::print(stderr, "{}\n", runs.error().message);
    return 2;
  }
  Figures figures;
  for (int run = 0; run < *runs; ++run) {
    if (const auto measured = measure(figures); !measured) {
      fmt::print(stderr, "{}\n", measured.error().message);
      return 1;
    }
  }
  fmt::print("bake, CPU-s                        {}\n", spread(figures.bake_cpu_s, 1));
  fmt::print("bake, million rays a CPU-s         {}\n", spread(figures.bake_rays_per_s, 2));
  fmt::print("bare Embree, million rays a CPU-s  {}\n", spread(figures.bare_rays_per_s, 2));
  for (std::size_t k = 0; k < std::size(kSamples); ++k) {
    fmt::print("frame, {} samples a pixel, CPU-s    {}\n", kSamples[k],
               spread(figures.frame_cpu_s[k], 3));
  }
  return 0;
}
