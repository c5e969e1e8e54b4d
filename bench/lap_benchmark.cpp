// Maps a recording that is played again and again, as a person walks through a known home, and
// prints what each thousand frames cost:
//   lap_benchmark RECORDING [FRAMES] [SEED] [CAMERA] [WORKING_SET_MB] [to-and-fro|again]
// CAMERA is a preset's name, or "own" for the recording's own. Played to and fro the motion stays
// continuous, but a shutter that rolls rolls the other way on the way back, as no camera's does;
// played again from its beginning each lap follows the one before after a second's pause, from
// another place.
// The first lap is the recording itself; each later one has an exposure and noise of its own, so
// that nothing is recognised by being the same picture. The processor time is that of the whole
// process, less that of making the noise. No networks: this measures mapping alone.

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "arguments.h"
#include "resident_memory.h"
#include "roomwise/base/random.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/recording/open_recording.h"

namespace {

using namespace roomwise;
namespace fs = std::filesystem;

constexpr std::uint64_t kThousand = 1000;

enum class Order { kToAndFro, kAgain };

// Frames 0 to n-1, then n-1 to 0 or 0 to n-1 again, and so on: the time goes on.
class Laps final : public recording::FrameSource {
 public:
  Laps(const recording::Recording& recording, std::uint64_t frames, std::uint64_t seed, Order order)
      : recording_(recording),
        frames_(frames),
        seed_(seed),
        order_(order),
        info_(recording.info()) {
    info_.frames_remaining = frames;
  }

  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  void skip_before(std::uint64_t index) override { next_ = index; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (next_ == frames_) return std::nullopt;
    auto frame = recording_.frame(recording_.frames()[original(next_)]);
    if (!frame || !*frame) return frame;
    (*frame)->index = next_;
    (*frame)->timestamp_ns = timestamp_ns(next_);
    if (lap(next_) > 0) add_noise(**frame);
    ++next_;
    return frame;
  }

  // Where the frames were taken, by the recording's ground truth.
  [[nodiscard]] recording::Trajectory truth(const recording::Trajectory& of_recording) const {
    constexpr TimestampNs kNear_ns = 20'000'000;
    recording::Trajectory truth;
    for (std::uint64_t i = 0; i < frames_; ++i) {
      const TimestampNs time = time_of(original(i));
      const auto after =
          std::ranges::lower_bound(of_recording, time, {}, &recording::StampedPose::timestamp_ns);
      for (const auto near : {after, after == of_recording.begin() ? after : after - 1}) {
        if (near == of_recording.end() || std::abs(near->timestamp_ns - time) > kNear_ns) continue;
        truth.push_back({timestamp_ns(i), near->world_from_camera});
        break;
      }
    }
    return truth;
  }
  // Of making the noise.
  [[nodiscard]] double noise_cpu_s() const { return noise_cpu_s_; }

 private:
  [[nodiscard]] std::uint64_t size() const { return recording_.frames().size(); }
  [[nodiscard]] std::uint64_t lap(std::uint64_t i) const { return i / size(); }
  [[nodiscard]] std::uint64_t original(std::uint64_t i) const {
    const std::uint64_t within = i % size();
    return goes_back(i) ? size() - 1 - within : within;
  }
  [[nodiscard]] bool goes_back(std::uint64_t i) const {
    return order_ == Order::kToAndFro && lap(i) % 2 == 1;
  }
  [[nodiscard]] TimestampNs time_of(std::uint64_t original) const {
    return recording_.find(recording_.frames()[original])->timestamp_ns;
  }
  // Each lap begins one mean interval after the one before ended, or, from the beginning, a second.
  [[nodiscard]] TimestampNs timestamp_ns(std::uint64_t i) const {
    const TimestampNs first = time_of(0);
    const TimestampNs last = time_of(size() - 1);
    const auto n = static_cast<TimestampNs>(size());
    constexpr TimestampNs kPause_ns = 1'000'000'000;
    const TimestampNs interval_ns = (last - first) / std::max<TimestampNs>(n - 1, 1);
    const TimestampNs lap_ns =
        last - first + (order_ == Order::kToAndFro ? interval_ns : kPause_ns);
    const TimestampNs time = time_of(original(i));
    return first + static_cast<TimestampNs>(lap(i)) * lap_ns +
           (goes_back(i) ? last - time : time - first);
  }

  // Brightness: a gain and an offset of the lap, a few levels a pixel. Depth: noise that grows with
  // the square of the distance, some 2 mm at 1 m. The encoded images stay the recording's.
  void add_noise(image::RgbdFrame& frame) {
    const double begin_s = thread_cpu_time_s();
    RandomStream of_lap(seed_, {lap(next_)});
    const double gain = 0.94 + 0.12 * of_lap.uniform();
    const double offset = 12 * of_lap.uniform() - 6;
    RandomStream random(seed_, {next_, 1});
    const auto noisy = [&](std::uint8_t level, std::uint64_t bits) {
      const double value = gain * level + offset + static_cast<double>(bits % 7) - 3;
      return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
    };
    for (Rgb8& pixel : frame.color.pixels()) {
      const std::uint64_t bits = random.next();
      pixel = {noisy(pixel.r, bits >> 8), noisy(pixel.g, bits >> 24), noisy(pixel.b, bits >> 40)};
    }
    const double to_m = 1 / recording_.info().camera.depth_units_per_metre;
    for (std::uint16_t& depth : frame.depth.pixels()) {
      if (depth == 0) continue;
      // The sum of four bytes is nearly normal, with a deviation of 147.8.
      const std::uint64_t bits = random.next();
      const auto byte = [&](int i) { return static_cast<int>((bits >> (8 * i)) & 255); };
      const double normal = (byte(0) + byte(1) + byte(2) + byte(3) - 510) / 147.8;
      const double z_m = depth * to_m;
      depth = static_cast<std::uint16_t>(
          std::clamp((z_m + 0.002 * z_m * z_m * normal) / to_m, 1.0, 65535.0));
    }
    noise_cpu_s_ += thread_cpu_time_s() - begin_s;
  }

  const recording::Recording& recording_;
  std::uint64_t frames_;
  std::uint64_t seed_;
  Order order_;
  std::uint64_t next_ = 0;
  double noise_cpu_s_ = 0;
  recording::SourceInfo info_;
};

// Prints a line each thousand frames.
class EachThousand final : public Progress {
 public:
  EachThousand(const Laps& laps, fs::path home) : laps_(laps), home_(std::move(home)) {}
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    mapping_ = work == "mapping";
    begin_s_ = cpu_s();
  }
  void advance(std::uint64_t done, std::string_view) override {
    if (!mapping_ || done % kThousand != 0) return;
    cpu_ms_.push_back((cpu_s() - begin_s_) * 1000 / kThousand);
    const auto home = home::Home::open_read_only(home_);
    const std::size_t keyframes = home ? home->keyframes()->size() : 0;
    const std::size_t edges = home ? home->edges()->size() : 0;
    fmt::print("| {} | {:.1f} | {:.0f} | {} | {} |\n", done, cpu_ms_.back(), bench::resident_mb(),
               keyframes, edges);
    std::fflush(stdout);
    begin_s_ = cpu_s();
  }
  void end() override { mapping_ = false; }
  // By thousand frames, for each frame.
  [[nodiscard]] const std::vector<double>& cpu_ms() const { return cpu_ms_; }

 private:
  [[nodiscard]] double cpu_s() const { return process_cpu_time_s() - laps_.noise_cpu_s(); }
  const Laps& laps_;
  fs::path home_;
  bool mapping_ = false;
  double begin_s_ = 0;
  std::vector<double> cpu_ms_;
};

struct Task {
  fs::path folder;
  std::uint64_t frames = 10'000;
  std::uint64_t seed = 1;
  recording::RecordingOptions how;
  std::size_t working_set_mb = 128;
  Order order = Order::kToAndFro;
};

Expected<void> map_laps(const Task& task, const fs::path& file) {
  ROOMWISE_TRY(const auto source, recording::open_recording(task.folder, task.how));
  Laps laps(*source, task.frames, task.seed, task.order);
  pipeline::MapSettings settings;
  settings.mapper.seed = task.seed;
  ROOMWISE_TRY(home::Home home, pipeline::create_home(file));
  ThreadPool pool(ThreadPool::default_size());
  StageClock clock;
  EachThousand progress(laps, file);
  pipeline::RunContext run{pool, progress, clock, task.working_set_mb << 20U};
  fmt::print(
      "{}: {} frames {}, {} in all, seed {}\n\n", source->info().name, source->frames().size(),
      task.order == Order::kToAndFro ? "to and fro" : "again and again", task.frames, task.seed);
  fmt::print(
      "| frames | CPU-ms a frame | resident MB | key-frames | edges |\n| --- | --- | --- | --- | "
      "--- |\n");
  const home::Recording stored{"laps", task.folder.string(), source->info().camera, task.frames};
  ROOMWISE_TRY(const auto summary, pipeline::map_recording(laps, stored, home, {}, settings, run));
  fmt::print("\n{} of {} frames placed, {} pieces, {} edges rejected", summary.placed,
             summary.frames, summary.components, summary.rejected_edges);
  if (progress.cpu_ms().size() > 1) {
    fmt::print("; CPU-ms of the last thousand over the first: {:.2f}",
               progress.cpu_ms().back() / progress.cpu_ms().front());
  }
  if (const auto truth = recording::read_trajectory(task.folder / "groundtruth.txt")) {
    ROOMWISE_TRY(const recording::Trajectory estimate, pipeline::stored_trajectory(home));
    ROOMWISE_TRY(const auto error,
                 evaluation::absolute_trajectory_error(laps.truth(*truth), estimate));
    fmt::print("; ATE RMSE {:.4f} m", error.error_m.rmse);
  }
  malloc_trim(0);  // what is free goes back to the system
  fmt::print("; {:.0f} MB resident now that the map is dropped\n", bench::resident_mb());
  for (const auto& [name, stage] : clock.stages()) {
    fmt::print("{}: {:.1f} CPU-ms a frame\n", name,
               1000 * stage.cpu_s / static_cast<double>(summary.frames));
  }
  return {};
}

Expected<Task> read_task(std::span<const char* const> arguments) {
  constexpr std::string_view kUsage =
      "lap_benchmark RECORDING [FRAMES] [SEED] [CAMERA] [WORKING_SET_MB] [to-and-fro|again]";
  if (arguments.empty() || arguments.size() > 6) return fail("usage: {}", kUsage);
  Task task{.folder = arguments[0], .how = {}};
  const auto take_count = [&](std::size_t place, auto& count) -> Expected<void> {
    if (arguments.size() <= place) return {};
    ROOMWISE_TRY(const int value, bench::parse_count(arguments[place], kUsage));
    count = static_cast<std::size_t>(value);
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(take_count(1, task.frames));
  ROOMWISE_RETURN_IF_ERROR(take_count(2, task.seed));
  ROOMWISE_RETURN_IF_ERROR(take_count(4, task.working_set_mb));
  if (arguments.size() > 3 && std::string_view(arguments[3]) != "own") {
    ROOMWISE_TRY(task.how.camera, geometry::camera_preset(arguments[3]));
  }
  if (arguments.size() > 5) {
    const std::string_view order = arguments[5];
    if (order != "again" && order != "to-and-fro") return fail("usage: {}", kUsage);
    if (order == "again") task.order = Order::kAgain;
  }
  return task;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const auto task = read_task({argv + 1, static_cast<std::size_t>(argc - 1)});
  if (!task) {
    fmt::print(stderr, "lap_benchmark: {}\n", task.error().message);
    return 2;
  }
  const fs::path file = fs::temp_directory_path() / fmt::format("lap-benchmark-{}.home", getpid());
  const auto mapped = map_laps(*task, file);
  fs::remove(file);
  if (!mapped) fmt::print(stderr, "{}\n", mapped.error().message);
  return mapped ? 0 : 1;
}
