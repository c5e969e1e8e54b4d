// What learning rooms from photos and varied ones costs, from the files to the classifier:
// processor time of each stage over all threads, and wall time. The photos are those of
// room_photos.
//
//   learning_benchmark [PHOTOS_PER_ROOM] [VARIANTS]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "arguments.h"
#include "roomwise/base/random.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace {

namespace fs = std::filesystem;
using namespace roomwise;

constexpr const char* kUsage = "learning_benchmark [PHOTOS_PER_ROOM] [VARIANTS]";

// A folder of the run's own that is gone at its end.
struct Scratch {
  fs::path path;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

// Links to the first photos of each room.
Expected<void> link_photos(const fs::path& folder, const fs::path& into, int per_room) {
  ROOMWISE_TRY(const auto photos, pipeline::list_room_photos(folder));
  std::map<std::string, int> taken;
  for (const pipeline::RoomPhoto& photo : photos) {
    if (++taken[photo.room] > per_room) continue;
    fs::create_directories(into / photo.room);
    fs::create_symlink(fs::absolute(photo.path), into / photo.room / photo.path.filename());
  }
  return {};
}

Expected<void> learn_once(const char* what, home::Home& home, const fs::path& photos,
                          const network::Classifier& network, int variants) {
  ThreadPool pool(ThreadPool::default_size());
  SilentProgress progress;
  StageClock clock;
  pipeline::RunContext run{pool, progress, clock};
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start_s = process_cpu_time_s();
  ROOMWISE_TRY(const auto report,
               pipeline::learn_rooms_from_photos(home, photos, network, {{}, variants}, run));
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  std::printf("%s: %zu photos, each with %d variants: %.1f s wall, %.1f CPU-s\n", what,
              report.held_out, variants, wall.count(), process_cpu_time_s() - cpu_start_s);
  for (const auto& [stage, time] : clock.stages()) {
    // The regression's other threads count for the process alone.
    std::printf("  %-36s %6zu times %8.2f s of wall time %8.2f CPU-s\n", stage.c_str(),
                static_cast<std::size_t>(time.calls), time.wall_s, time.cpu_s);
  }
  return {};
}

// The regression alone: `pictures` of eight rooms, each with four variants, of 2,048 made-up
// features that are none below zero and of 60 kinds mixed, as a network's are.
Expected<void> time_regression(std::size_t pictures) {
  constexpr std::size_t kRooms = 8;
  constexpr std::size_t kKinds = 60;
  constexpr std::size_t kFeatures = 2048;
  RandomStream random(1);
  std::vector<std::vector<float>> kinds(kKinds, std::vector<float>(kFeatures));
  for (auto& kind : kinds) {
    for (float& value : kind) value = static_cast<float>(std::max(0.0, random.normal() - 1));
  }
  std::vector<rooms::RoomSample> samples(pictures);
  for (std::size_t i = 0; i < pictures; ++i) {
    const std::size_t room = i * kRooms / pictures;
    std::vector<double> mix;
    for (std::size_t k = 0; k < kKinds; ++k) {
      mix.push_back(std::abs(random.normal()) * (k % kRooms == room ? 1.4 : 1));
    }
    const auto seen = [&] {
      std::vector<float> features(kFeatures);
      for (std::size_t k = 0; k < kKinds; ++k) {
        const auto share = static_cast<float>(mix[k] * (1 + 0.2 * random.normal()));
        for (std::size_t f = 0; f < kFeatures; ++f) features[f] += share * kinds[k][f];
      }
      for (float& value : features) value += static_cast<float>(0.3 * std::abs(random.normal()));
      return features;
    };
    samples[i] = {seen(), "room" + std::to_string(room)};
    for (int variant = 0; variant < 4; ++variant) samples[i].variants.push_back(seen());
  }
  ThreadPool pool(ThreadPool::default_size());
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start_s = process_cpu_time_s();
  ROOMWISE_TRY(const auto learned, rooms::learn_rooms(samples, {"made up", ""}, {}, &pool));
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  std::printf(
      "regression alone: %zu pictures x 5 x %zu features, %zu rooms: %.2f s wall, %.2f CPU-s\n",
      pictures, kFeatures, kRooms, wall.count(), process_cpu_time_s() - cpu_start_s);
  return {};
}

Expected<void> run(int argc, char** argv) {
  if (argc > 3) return fail("'{}' is one argument too many; usage: {}", argv[3], kUsage);
  int per_room = 100;
  int variants = 4;
  if (argc > 1) {
    ROOMWISE_TRY(per_room, bench::parse_count(argv[1], kUsage));
  }
  if (argc > 2) {
    ROOMWISE_TRY(variants, bench::parse_count(argv[2], kUsage));
  }
  ROOMWISE_RETURN_IF_ERROR(time_regression(2000));
  const char* data = std::getenv("ROOMWISE_DATA");
  const auto models = network::default_model_folder();
  if (data == nullptr || !models) return fail("set ROOMWISE_DATA and ROOMWISE_MODELS");
  ROOMWISE_TRY(const auto network,
               network::OnnxClassifier::load(*models / "inception-2015-12-05-trunk.onnx"));
  std::string pattern = (fs::temp_directory_path() / "roomwise-learning-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) return fail("{}: cannot be made", pattern);
  const Scratch scratch{pattern};
  const fs::path photos = scratch.path / "photos";
  ROOMWISE_RETURN_IF_ERROR(link_photos(fs::path(data) / "room_photos" / "train", photos, per_room));
  ROOMWISE_TRY(home::Home home, pipeline::create_home(scratch.path / "photos.home"));
  ROOMWISE_RETURN_IF_ERROR(learn_once("first", home, photos, *network, variants));
  return learn_once("again", home, photos, *network, variants);
}

}  // namespace

int main(int argc, char** argv) {
  if (const auto done = run(argc, argv); !done) {
    std::fprintf(stderr, "learning_benchmark: %s\n", done.error().message.c_str());
    return 1;
  }
  return 0;
}
