#include "laboratory/simulation/recording/simulate_views.h"

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/sensor/sensor.h"
#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/image/codec.h"

namespace roomwise::simulation {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::uint64_t kScenarioStream = 0x5CE7Au;
constexpr const char* kManifest = "views.json";

// What is written about the pictures; "homes" grows.
ordered_json new_manifest(const ViewsOptions& options) {
  std::vector<std::string_view> rooms;
  for (const RoomKind room : options.rooms) rooms.push_back(name_of(room));
  return {{"first_home", options.first_home},
          {"rooms", rooms},
          {"seed", options.seed},
          {"of_kind", options.views.of_kind},
          {"of_room", options.views.of_room},
          {"longer_side_px", options.views.longer_side_px},
          {"samples_per_pixel", options.render.samples_per_pixel},
          {"bake_effort", options.render.bake_effort},
          {"jpeg_quality", options.jpeg_quality},
          {"homes", ordered_json::array()},
          {"models", ordered_json::array()}};
}

// The same but for what grows.
bool is_of_same_options(ordered_json made, const ordered_json& wanted) {
  if (!made.is_object()) return false;
  const auto is_home = [](const ordered_json& home) {
    return home.is_object() && home.contains("pictures") && home["pictures"].is_number_unsigned();
  };
  for (const char* grows : {"homes", "models"}) {
    if (!made.contains(grows) || !made[grows].is_array()) return false;
  }
  if (!std::ranges::all_of(made["homes"], is_home) ||
      !std::ranges::all_of(made["models"], [](const auto& name) { return name.is_string(); })) {
    return false;
  }
  made["homes"] = made["models"] = ordered_json::array();
  return made == wanted;
}

// What the folder holds already, or nothing yet.
Expected<ordered_json> begin_folder(const fs::path& folder, const ViewsOptions& options) {
  ordered_json manifest = new_manifest(options);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  const bool is_begun = fs::exists(folder / kManifest, error);
  if (!is_begun) {
    const bool is_empty = fs::is_empty(folder, error);
    if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
    if (!is_empty) {
      return fail(
          "{}: is not empty; give a new folder, or one that holds views of the same options",
          folder.string());
    }
    ROOMWISE_RETURN_IF_ERROR(write_file(folder / kManifest, manifest.dump(1) + "\n"));
    return manifest;
  }
  ROOMWISE_TRY(const std::string text, read_text_file(folder / kManifest));
  ordered_json made = ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!is_of_same_options(made, manifest)) {
    return fail(
        "{}: holds views of other options; give a new folder, or the options that its {} names",
        folder.string(), kManifest);
  }
  return made;
}

// Furniture recurs from home to home: each model is read once.
class CachedMeshes {
 public:
  explicit CachedMeshes(const FurnitureCatalogue& catalogue) : catalogue_(catalogue) {}

  Expected<TriangleMesh> load(const std::string& model) {
    const auto found = meshes_.find(model);
    if (found != meshes_.end()) return found->second;
    ROOMWISE_TRY(TriangleMesh mesh, catalogue_.load(model));
    return meshes_.emplace(model, std::move(mesh)).first->second;
  }

 private:
  const FurnitureCatalogue& catalogue_;
  std::map<std::string, TriangleMesh> meshes_;
};

// Takes the pictures of one home.
class HomePhotographer {
 public:
  HomePhotographer(const ViewsOptions& options, const HomeModel& home, const Renderer& renderer,
                   const fs::path& folder, ThreadPool& pool)
      : options_(options), home_(home), renderer_(renderer), folder_(folder), pool_(pool) {
    sensor_options_.seed = RandomStream(options.seed, {home.seed}).next();
  }

  Expected<void> take(const SampledView& view, std::size_t index) {
    const RenderedFrame seen = renderer_.render(view.camera, view.world_from_camera, pool_);
    ROOMWISE_TRY(const Sensor sensor, Sensor::create(view.camera, sensor_options_));
    ExposureControl exposure(sensor_options_);
    const WalkPose pose = moving_pose(view.world_from_camera, view.room, view.pace);
    const image::RgbdFrame frame =
        sensor.capture(seen, pose, index, exposure.next(seen, 0, index), pool_);
    const fs::path of_class = folder_ / view.shows;
    std::error_code error;
    fs::create_directories(of_class, error);
    if (error) return fail("{}: cannot be made: {}", of_class.string(), error.message());
    return write_file(of_class / fmt::format("home-{:05}-{:04}.jpg", home_.seed, index),
                      image::encode_jpeg(frame.color, options_.jpeg_quality));
  }

 private:
  const ViewsOptions& options_;
  const HomeModel& home_;
  const Renderer& renderer_;
  const fs::path& folder_;
  ThreadPool& pool_;
  SensorOptions sensor_options_;
};

class ViewsWriter {
 public:
  ViewsWriter(const ViewsOptions& options, const FurnitureCatalogue& catalogue,
              const fs::path& folder, ordered_json manifest, ThreadPool& pool, Progress& progress)
      : options_(options),
        catalogue_(catalogue),
        meshes_(catalogue),
        folder_(folder),
        manifest_(std::move(manifest)),
        pool_(pool),
        progress_(progress) {
    for (const auto& model : manifest_["models"]) models_.insert(model.get<std::string>());
    for (const auto& home : manifest_["homes"]) pictures_ += home["pictures"].get<std::uint64_t>();
  }

  [[nodiscard]] std::uint64_t homes() const { return manifest_["homes"].size(); }
  [[nodiscard]] std::uint64_t pictures() const { return pictures_; }

  // Nothing is noted of a home that is interrupted: its pictures are taken again.
  Expected<void> add_home(std::uint64_t seed) {
    const Scenario scenario = scenario_of(seed, options_.seed);
    ROOMWISE_TRY(HomeModel by_day, generate_home({seed, options_.rooms}, catalogue_));
    const HomeModel home = apply_scenario(std::move(by_day), scenario, seed, catalogue_.models());
    const MeshLoader load = [this](const std::string& model) { return meshes_.load(model); };
    SilentProgress silent;
    ROOMWISE_TRY(const auto renderer, Renderer::create(home, load, options_.render, pool_, silent));
    HomeViewOptions views_options = options_.views;
    views_options.seed = options_.seed;
    ROOMWISE_TRY(const auto views, choose_home_views(home, load, *renderer, views_options, pool_));
    HomePhotographer photographer(options_, home, *renderer, folder_, pool_);
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (progress_.interrupted()) return {};
      ROOMWISE_RETURN_IF_ERROR(photographer.take(views[i], i));
    }
    return note(home, views.size());
  }

 private:
  Expected<void> note(const HomeModel& home, std::size_t pictures) {
    pictures_ += pictures;
    for (const PlacedObject& object : home.objects) models_.insert(object.model);
    manifest_["homes"].push_back(
        {{"seed", home.seed}, {"scenario", name_of(home.scenario)}, {"pictures", pictures}});
    manifest_["models"] = models_;
    ROOMWISE_TRY(const std::string credits,
                 catalogue_.credits(std::vector<std::string>(models_.begin(), models_.end())));
    ROOMWISE_RETURN_IF_ERROR(write_file(folder_ / "credits.txt", credits));
    return write_file(folder_ / kManifest, manifest_.dump(1) + "\n");
  }

  const ViewsOptions& options_;
  const FurnitureCatalogue& catalogue_;
  CachedMeshes meshes_;
  const fs::path& folder_;
  ordered_json manifest_;
  ThreadPool& pool_;
  Progress& progress_;
  std::set<std::string> models_;
  std::uint64_t pictures_ = 0;
};

}  // namespace

Expected<void> ViewsOptions::validate() const {
  if (first_home > last_home) {
    return fail("the homes are {} to {}; the first must not come after the last", first_home,
                last_home);
  }
  constexpr int kMinSide_px = 32, kMaxSide_px = 2048;
  if (views.longer_side_px < kMinSide_px || views.longer_side_px > kMaxSide_px) {
    return fail("the pictures are {} px long; expected {} to {}", views.longer_side_px, kMinSide_px,
                kMaxSide_px);
  }
  if (views.of_kind + views.of_room == 0) return fail("neither pieces nor rooms are looked at");
  if (jpeg_quality < 1 || jpeg_quality > 100) {
    return fail("the JPEG quality is {}; expected 1 to 100", jpeg_quality);
  }
  return render.validate();
}

Scenario scenario_of(std::uint64_t home_seed, std::uint64_t seed) {
  constexpr std::array kScenarios{Scenario::kDay,   Scenario::kDay,   Scenario::kEvening,
                                  Scenario::kNight, Scenario::kMoved, Scenario::kMovedNight};
  return kScenarios[RandomStream(seed, {kScenarioStream, home_seed}).index(kScenarios.size())];
}

Expected<ViewsSummary> simulate_views(const ViewsOptions& options,
                                      const FurnitureCatalogue& catalogue, const fs::path& folder,
                                      ThreadPool& pool, Progress& progress) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(ordered_json manifest, begin_folder(folder, options));
  ViewsWriter writer(options, catalogue, folder, std::move(manifest), pool, progress);
  const std::uint64_t homes = options.last_home - options.first_home + 1;
  progress.begin("looking at homes", homes);
  Expected<void> added;
  while (added && writer.homes() < homes && !progress.interrupted()) {
    const std::uint64_t seed = options.first_home + writer.homes();
    added = writer.add_home(seed).map_error([seed](Error error) {
      return std::move(error).with_context(fmt::format("home {}", seed));
    });
    progress.advance(writer.homes(), fmt::format("{} pictures", writer.pictures()));
  }
  progress.end();
  ROOMWISE_RETURN_IF_ERROR(added);
  return ViewsSummary{writer.homes(), writer.pictures(), writer.homes() >= homes};
}

}  // namespace roomwise::simulation
