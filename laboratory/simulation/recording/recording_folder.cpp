#include "laboratory/simulation/recording/recording_folder.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "laboratory/simulation/recording/simulation_file.h"
#include "laboratory/simulation/render/true_surfaces.h"

namespace roomwise::simulation {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFinished = "simulation.json", kUnfinished = "unfinished.json";
constexpr std::array<std::string_view, 8> kFiles{
    "rgb.txt",         "depth.txt",    "camera.txt",     "rooms.txt",
    "groundtruth.txt", "objects.json", "floorplan.json", "credits.txt"};

// A file of this name, or what a killed write_file() left of it.
bool is_ours(const std::string& name) {
  for (const std::string_view file : kFiles) {
    if (name == file || name.starts_with(std::string(file) + ".partial-")) return true;
  }
  return false;
}

// The files that simulate_recording() writes before it is done. Fails where there is another.
Expected<std::vector<fs::path>> files_of_unfinished(const fs::path& folder) {
  std::vector<fs::path> files;
  const auto refuse = [&](const fs::path& path) {
    return fail("{}: holds {}, which no simulation wrote; move that away, or give another folder",
                folder.string(), path.lexically_relative(folder).string());
  };
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name == kUnfinished) continue;
    if (!entry.is_directory()) {
      if (!is_ours(name)) return refuse(entry.path());
      files.push_back(entry.path());
      continue;
    }
    if (name != "rgb" && name != "depth") return refuse(entry.path());
    for (const fs::directory_entry& image : fs::directory_iterator(entry.path())) {
      const std::string type = image.path().extension();
      if (!image.is_regular_file() || (type != ".jpg" && type != ".png")) {
        return refuse(image.path());
      }
      files.push_back(image.path());
    }
    files.push_back(entry.path());
  }
  return files;
}

}  // namespace

Expected<bool> is_made_already(const fs::path& folder, const SimulationOptions& options,
                               const FurnitureCatalogue& catalogue) {
  const auto made = read_simulation(folder / kFinished);
  if (!made || !are_alike(made->options, options)) return false;
  ROOMWISE_TRY(const HomeModel home, make_home(options, catalogue));
  ROOMWISE_TRY(const TrueSurfaces surfaces, TrueSurfaces::create(home, [&](const std::string& id) {
                 return catalogue.load(id);
               }));
  if (surfaces.digest() == made->scene_sha256) return true;
  return fail(
      "{}: holds a recording of these options, but of a home that another version of the program, "
      "or of its furniture, made of them; remove it to make it anew, or give another folder",
      folder.string());
}

Expected<void> remove_unfinished(const fs::path& folder, const SimulationOptions& options) {
  std::error_code error;
  const bool is_unfinished = fs::exists(folder / kUnfinished, error);
  if (!is_unfinished || fs::exists(folder / kFinished, error)) return {};
  try {
    ROOMWISE_TRY(const auto files, files_of_unfinished(folder));
    const bool has_frames = std::ranges::any_of(
        files, [&](const fs::path& file) { return file.parent_path() == folder / "rgb"; });
    const auto begun = read_simulation(folder / kUnfinished);
    if (has_frames && (!begun || !are_alike(begun->options, options))) {
      return fail(
          "{}: holds an unfinished recording of other options; finish it with those, remove it, or "
          "give another folder",
          folder.string());
    }
    for (const fs::path& file : files) fs::remove(file);
    // Last: a removal that is broken off can be taken up again.
    fs::remove(folder / kUnfinished);
  } catch (const fs::filesystem_error& failure) {
    return fail("{}: the unfinished recording cannot be removed: {}", folder.string(),
                failure.code().message());
  }
  return {};
}

Expected<void> mark_unfinished(const fs::path& folder, const SimulationOptions& options) {
  return write_simulation(folder / kUnfinished, {options, ""});
}

Expected<void> mark_finished(const fs::path& folder, const SimulationOptions& options,
                             const std::string& scene_digest) {
  ROOMWISE_RETURN_IF_ERROR(write_simulation(folder / kFinished, {options, scene_digest}));
  std::error_code ignored;  // with simulation.json beside it the mark says nothing
  fs::remove(folder / kUnfinished, ignored);
  return {};
}

}  // namespace roomwise::simulation
