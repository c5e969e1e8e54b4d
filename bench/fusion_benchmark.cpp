// What a dense map of a home costs, and whether it follows corrected poses to the bit:
//   fusion_benchmark HOME ...
// Each home is fused in a process of its own, on one thread beside the main one, so that its
// processor time and peak memory are its own. Times with decoding of the stored images where it
// says so.

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "roomwise/pipeline/mapping/gravity_aligned_map.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace {

using namespace roomwise;

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1000;
}

// Every tenth key-frame moved by some centimetres, as a loop closure would.
std::vector<home::Keyframe> bent(std::vector<home::Keyframe> keyframes) {
  for (std::size_t i = 0; i < keyframes.size(); i += 10) {
    keyframes[i].pose.world_from_keyframe.translation += Eigen::Vector3d(0.05, 0.02, -0.03);
  }
  return keyframes;
}

Expected<void> measure(const char* file) {
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(file));
  ROOMWISE_TRY(const auto keyframes, pipeline::map_keyframes(home));
  ThreadPool pool(1);
  SilentProgress progress;
  StageClock clock;
  pipeline::RunContext run{pool, progress, clock};

  const double begin_s = process_cpu_time_s();
  ROOMWISE_TRY(pipeline::DenseMap map, pipeline::build_dense_map(home, keyframes, {}, run));
  const double fused_s = process_cpu_time_s();
  ROOMWISE_TRY(const fusion::PiecewiseMesh mesh,
               extract_mesh(map.field(), fusion::MeshOptions{}, pool));
  const double meshed_s = process_cpu_time_s();
  const double field_mb = static_cast<double>(map.field().memory_bytes()) / 1e6;
  const double max_mb = peak_mb();

  const auto moved = bent(keyframes);
  ROOMWISE_TRY(pipeline::DenseMap other, pipeline::build_dense_map(home, moved, {}, run));
  const double bent_s = process_cpu_time_s();
  ROOMWISE_RETURN_IF_ERROR(other.follow(home, keyframes, run));
  const double followed_s = process_cpu_time_s();
  const double moved_count = static_cast<double>((keyframes.size() + 9) / 10);

  const double count = static_cast<double>(keyframes.size());
  const double surfaces_ms = 1000 * clock.stages().at("surfaces").cpu_s /
                             static_cast<double>(clock.stages().at("surfaces").calls);
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.2f} | {:.0f} | {:.0f} | {} | {} | {:.0f} | {} |\n",
             file, keyframes.size(), 1000 * (fused_s - begin_s) / count, surfaces_ms,
             meshed_s - fused_s, field_mb, max_mb, mesh.vertex_count(), mesh.triangle_count(),
             1000 * (followed_s - bent_s) / moved_count,
             other.field() == map.field() ? "yes" : "NO");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: fusion_benchmark HOME ...\n");
    return 2;
  }
  fmt::print(
      "| home | key-frames | fuse a key-frame, CPU-ms | of it its surface | mesh, CPU-s | field, "
      "MB "
      "| peak, MB | vertices | triangles | a key-frame that moved, CPU-ms | the same field |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (int i = 1; i < argc; ++i) {
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
      const auto measured = measure(argv[i]);
      if (!measured) fmt::print(stderr, "{}\n", measured.error().message);
      std::fflush(stdout);
      _exit(measured ? 0 : 1);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0) return 1;
  }
  return 0;
}
