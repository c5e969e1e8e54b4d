#include "laboratory/simulation/recording/simulate_recording.h"

#include <future>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "laboratory/simulation/home/bare_halls.h"
#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/recording/recording_folder.h"
#include "roomwise/base/file.h"
#include "roomwise/recording/trajectory_file.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::simulation {
namespace {

// Draws the walk frame by frame and notes what only the simulation knows.
class WalkRecorder {
 public:
  WalkRecorder(const SimulationOptions& options, const HomeModel& home, const Renderer& renderer,
               const Sensor& sensor, recording::TumWriter& writer, ThreadPool& pool,
               StageClock& clock)
      : options_(options),
        home_(home),
        renderer_(renderer),
        sensor_(sensor),
        exposure_(options.sensor),
        writer_(writer),
        pool_(pool),
        clock_(clock),
        observations_(home.objects.size()) {}

  Expected<void> record(const WalkPose& pose, std::uint64_t index) {
    RenderedFrame seen = [&] {
      const auto timing = clock_.measure("render");
      return renderer_.render(options_.camera, pose.world_from_camera, pool_);
    }();
    image::RgbdFrame frame = [&] {
      const auto timing = clock_.measure("sensor");
      const ColorSettings settings = exposure_.next(seen, pose.timestamp_ns, index);
      return sensor_.capture(seen, pose, index, settings, pool_);
    }();
    ROOMWISE_RETURN_IF_ERROR(finish());
    // Its images are encoded while the next frame is drawn.
    auto raw = std::make_shared<image::RgbdFrame>(std::move(frame));
    pending_.emplace(Pending{pose, index, std::move(seen.object), pool_.submit([raw] {
                               return recording::encode_images(std::move(*raw));
                             })});
    return {};
  }

  // Writes the frame that was recorded last.
  Expected<void> finish() {
    if (!pending_) return {};
    const auto timing = clock_.measure("write");
    Pending written = *std::exchange(pending_, std::nullopt);
    const image::RgbdFrame frame = written.encoded.get();
    ROOMWISE_RETURN_IF_ERROR(writer_.name_room(home_.rooms[written.pose.room].name));
    ROOMWISE_RETURN_IF_ERROR(writer_.write(frame));
    observations_.add(written.index, written.object);
    trajectory_.push_back({written.pose.timestamp_ns, written.pose.world_from_camera});
    return {};
  }

  [[nodiscard]] const recording::Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const ObservationCounter& observations() const { return observations_; }

 private:
  const SimulationOptions& options_;
  const HomeModel& home_;
  const Renderer& renderer_;
  const Sensor& sensor_;
  ExposureControl exposure_;
  recording::TumWriter& writer_;
  ThreadPool& pool_;
  StageClock& clock_;
  // The frame that is to be written next.
  struct Pending {
    WalkPose pose;
    std::uint64_t index = 0;
    image::Image<std::uint16_t> object;
    std::future<image::RgbdFrame> encoded;
  };
  std::optional<Pending> pending_;
  recording::Trajectory trajectory_;
  ObservationCounter observations_;
};

Expected<std::string> credits_of(const HomeModel& home, const FurnitureCatalogue& catalogue) {
  std::set<std::string> ids;
  for (const PlacedObject& object : home.objects) ids.insert(object.model);
  return catalogue.credits(std::vector<std::string>(ids.begin(), ids.end()));
}

}  // namespace

geometry::PinholeCamera SimulationOptions::default_camera() {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.width = 640;
  camera.height = 480;
  camera.depth_units_per_metre = 5000;
  return camera;
}

Expected<void> SimulationOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(walk.validate());
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  ROOMWISE_RETURN_IF_ERROR(render.validate());
  return sensor.validate();
}

Expected<HomeModel> make_home(const SimulationOptions& options,
                              const FurnitureCatalogue& catalogue) {
  ROOMWISE_TRY(HomeModel by_day,
               options.home ? generate_home(*options.home, catalogue) : reference_flat(catalogue));
  if (options.bare_halls) by_day = with_bare_halls(std::move(by_day));
  return apply_scenario(std::move(by_day), options.scenario, options.scenario_seed,
                        catalogue.models());
}

Expected<SimulationSummary> simulate_recording(const SimulationOptions& options,
                                               const FurnitureCatalogue& catalogue,
                                               const std::filesystem::path& folder,
                                               ThreadPool& pool, Progress& progress,
                                               StageClock& clock) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const HomeModel plan, make_home(options, catalogue));
  ROOMWISE_TRY(const std::vector<WalkPose> walk, plan_walk(plan, options.walk));
  const HomeModel home = in_world(plan);
  ROOMWISE_TRY(const Sensor sensor, Sensor::create(options.camera, options.sensor));
  // Before the long work, which a folder that cannot be written or is not empty would waste.
  const bool is_new = !std::filesystem::exists(folder);
  ROOMWISE_RETURN_IF_ERROR(remove_unfinished(folder, options));
  ROOMWISE_TRY(auto writer, recording::TumWriter::create(folder, options.camera));
  ROOMWISE_RETURN_IF_ERROR(mark_unfinished(folder, options));
  auto renderer = Renderer::create(home, catalogue, options.render, pool, progress);
  if (!renderer) {
    // Nothing was drawn: the folder is left as it was found.
    writer.reset();
    ROOMWISE_RETURN_IF_ERROR(remove_unfinished(folder, options));
    std::error_code ignored;
    if (is_new) std::filesystem::remove(folder, ignored);
    return Unexpected(std::move(renderer).error());
  }

  WalkRecorder recorder(options, home, **renderer, sensor, *writer, pool, clock);
  progress.begin("drawing the walk", walk.size());
  // The frames before one that cannot be written keep their truth.
  Expected<void> recorded;
  for (std::size_t i = 0; i < walk.size() && !progress.interrupted(); ++i) {
    recorded = recorder.record(walk[i], i);
    if (!recorded) break;
    progress.advance(i + 1, home.rooms[walk[i].room].name);
  }
  if (recorded) recorded = recorder.finish();
  progress.end();
  ROOMWISE_RETURN_IF_ERROR(writer->close());
  const recording::Trajectory& truth = recorder.trajectory();
  ROOMWISE_RETURN_IF_ERROR(recording::write_trajectory(folder / "groundtruth.txt", truth));
  ROOMWISE_RETURN_IF_ERROR(write_objects_truth(
      folder / "objects.json", objects_truth(home, catalogue.models(), recorder.observations())));
  ROOMWISE_RETURN_IF_ERROR(write_floor_plan(folder / "floorplan.json", plan));
  ROOMWISE_TRY(const std::string credits, credits_of(home, catalogue));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "credits.txt", credits));
  ROOMWISE_RETURN_IF_ERROR(recorded);

  SimulationSummary summary;
  summary.frames = truth.size();
  summary.seconds =
      truth.size() < 2
          ? 0
          : static_cast<double>(truth.back().timestamp_ns - truth.front().timestamp_ns) / 1e9;
  summary.rooms = home.rooms.size();
  summary.objects = home.objects.size();
  summary.bake = (*renderer)->bake_statistics();
  summary.finished = truth.size() == walk.size();
  if (summary.finished) {
    ROOMWISE_RETURN_IF_ERROR(mark_finished(folder, options, (*renderer)->scene_digest()));
  }
  return summary;
}

}  // namespace roomwise::simulation
