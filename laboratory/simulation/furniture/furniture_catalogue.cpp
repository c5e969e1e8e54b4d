#include "laboratory/simulation/furniture/furniture_catalogue.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "laboratory/simulation/furniture/furniture_archive.h"
#include "laboratory/simulation/furniture/furniture_list.h"
#include "laboratory/simulation/furniture/furniture_properties.h"
#include "laboratory/simulation/furniture/mesh_loader.h"

namespace roomwise::simulation {
namespace {

constexpr const char* kPropertyFile = "PluginFurnitureCatalog.properties";

// A model that an archive offers.
struct Offer {
  std::filesystem::path archive;
  FurnitureProperties properties;
};
using Offers = std::map<std::string, Offer, std::less<>>;  // by id

// A line of furniture.txt.
struct Choice {
  std::string kind, id;
  int quarter_turns = 0;
  double scale = 1;
  std::optional<double> top_m, elevation_m;
};

Expected<std::vector<std::filesystem::path>> archives_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> archives;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".sh3f") archives.push_back(entry.path());
  }
  if (archives.empty()) {
    return fail("{}: holds no furniture (*.sh3f); {}", folder.string(), kInstallFurniture);
  }
  std::ranges::sort(archives);
  return archives;
}

Expected<void> add_offers(const std::filesystem::path& path, Offers& offers) {
  ROOMWISE_TRY(const auto archive, FurnitureArchive::open(path));
  ROOMWISE_TRY(const Bytes text, archive.read(kPropertyFile));
  auto models =
      parse_furniture_properties({reinterpret_cast<const char*>(text.data()), text.size()});
  if (!models) {
    return Unexpected(std::move(models).error().with_context(
        fmt::format("{}: {}", path.string(), kPropertyFile)));
  }
  for (FurnitureProperties& model : *models) {
    offers.try_emplace(model.id, Offer{path, model});
  }
  return {};
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (!line.empty()) {
    const auto first = std::min(line.find_first_not_of(' '), line.size());
    line.remove_prefix(first);
    const auto end = std::min(line.find(' '), line.size());
    if (end > 0) words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

// "turn=90", "scale=0.8", "top=0.45" or "elevation=1.5".
Expected<void> apply_option(std::string_view option, Choice& choice) {
  const auto equals = std::min(option.find('='), option.size());
  const std::string_view key = option.substr(0, equals);
  const std::string_view value = option.substr(std::min(equals + 1, option.size()));
  double number = 0;
  const auto [end, code] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool is_number = code == std::errc{} && end == value.data() + value.size();
  if (is_number && key == "top") {
    choice.top_m = number;
  } else if (is_number && key == "elevation") {
    choice.elevation_m = number;
  } else if (is_number && key == "scale" && number > 0) {
    choice.scale = number;
  } else if (is_number && key == "turn" && std::remainder(number, 90.0) == 0) {
    choice.quarter_turns = static_cast<int>(number / 90.0);
  } else {
    return fail("furniture.txt: {}: '{}' is none of turn=90 (180, 270), scale=, top=, elevation=",
                choice.id, option);
  }
  return {};
}

Expected<std::vector<Choice>> parse_list(std::string_view text) {
  std::vector<Choice> choices;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty() || words[0].starts_with('#')) continue;
    if (words.size() < 2) return fail("furniture.txt: '{}' names no model", words[0]);
    Choice choice;
    choice.kind = words[0];
    choice.id = words[1];
    for (const std::string_view option : std::span(words).subspan(2)) {
      ROOMWISE_RETURN_IF_ERROR(apply_option(option, choice));
    }
    choices.push_back(std::move(choice));
  }
  return choices;
}

// The catalogue's axes are x to the right, y up, z to the front; the object frame has the front at
// -y.
Eigen::Matrix3d object_from_model(const Choice& choice, const FurnitureProperties& properties) {
  Eigen::Matrix3d object_from_catalogue;
  object_from_catalogue << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  Eigen::Matrix3d quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (int i = 0; i < choice.quarter_turns; ++i) turn = quarter * turn;
  return turn * object_from_catalogue * properties.rotation;
}

FurnitureModel model_of(const Choice& choice, const FurnitureProperties& properties) {
  FurnitureModel model;
  model.id = choice.id;
  model.kind = choice.kind;
  model.name = properties.name;
  model.size_m = choice.scale * properties.size_m;
  if (choice.quarter_turns % 2 != 0) std::swap(model.size_m.x(), model.size_m.y());
  model.top_m = choice.top_m.value_or(choice.scale * properties.top_m);
  model.elevation_m = choice.elevation_m.value_or(properties.elevation_m);
  model.creator = properties.creator;
  model.license = properties.license;
  return model;
}

}  // namespace

Expected<FurnitureCatalogue> FurnitureCatalogue::open(const std::filesystem::path& folder) {
  ROOMWISE_TRY(const auto archives, archives_in(folder));
  Offers offers;
  for (const auto& archive : archives) ROOMWISE_RETURN_IF_ERROR(add_offers(archive, offers));
  ROOMWISE_TRY(const auto choices, parse_list(furniture_list()));
  FurnitureCatalogue catalogue;
  for (const Choice& choice : choices) {
    const auto offer = offers.find(choice.id);
    if (offer == offers.end()) {
      return fail("{}: no archive holds the model {}; {}", folder.string(), choice.id,
                  kInstallFurniture);
    }
    const auto& [archive, properties] = offer->second;
    catalogue.models_.push_back(model_of(choice, properties));
    catalogue.sources_[choice.id] = {archive, properties.model_path,
                                     object_from_model(choice, properties)};
  }
  return catalogue;
}

std::vector<const FurnitureModel*> FurnitureCatalogue::of_kind(std::string_view kind) const {
  std::vector<const FurnitureModel*> found;
  for (const FurnitureModel& model : models_) {
    if (model.kind == kind) found.push_back(&model);
  }
  return found;
}

const FurnitureModel* FurnitureCatalogue::find(std::string_view id) const {
  const auto found = std::ranges::find(models_, id, &FurnitureModel::id);
  return found == models_.end() ? nullptr : &*found;
}

Expected<TriangleMesh> FurnitureCatalogue::load(std::string_view id) const {
  const FurnitureModel* model = find(id);
  if (model == nullptr) return fail("{}: not a model of the furniture catalogue", id);
  const Source& source = sources_.find(id)->second;
  // Every call opens the archive for itself, so that threads need not wait for each other.
  ROOMWISE_TRY(const auto archive, FurnitureArchive::open(source.archive));
  const auto slash = source.path.rfind('/');
  const std::string model_folder = source.path.substr(0, slash);
  const ModelFolder folder{archive.files_in(model_folder), [&](const std::string& name) {
                             return archive.read(model_folder + "/" + name);
                           }};
  auto mesh =
      load_mesh(folder, source.path.substr(slash + 1), {source.object_from_model, model->size_m});
  if (!mesh) return Unexpected(std::move(mesh).error().with_context(model_folder));
  return mesh;
}

Expected<std::string> FurnitureCatalogue::credits(std::span<const std::string> ids) const {
  std::set<std::string> lines;
  for (const std::string& id : ids) {
    const FurnitureModel* model = find(id);
    if (model == nullptr) return fail("{}: not a model of the furniture catalogue", id);
    lines.insert(
        fmt::format("{} ({}) by {}: {}\n", model->name, model->id, model->creator, model->license));
  }
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

}  // namespace roomwise::simulation
