#include "networks.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <ranges>
#include <set>
#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/network/vision/open_vocabulary.h"
#include "roomwise/pipeline/objects/changed_networks.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// What a network is to be for.
using IsFor = bool (*)(network::Task);
bool classifies(network::Task task) {
  return task == network::Task::kClassify;
}

bool matches_words(network::Task task) {
  return task == network::Task::kMatchWords;
}

// The networks of a folder that are for this, by their cards; by name.
Expected<std::vector<fs::path>> list_networks(const fs::path& folder, IsFor is_for) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!network::has_ending_of_network(entry->path())) continue;
    const auto card = network::find_model_card(entry->path());
    if (card && is_for(card->task)) files.push_back(entry->path());
  }
  if (error)
    return fail("{}: the folder of networks (ROOMWISE_MODELS) cannot be read: {}", folder.string(),
                error.message());
  std::ranges::sort(files);
  return files;
}

// Those of all folders; the first folder that has a file counts.
Expected<std::vector<fs::path>> networks_for(IsFor is_for) {
  std::vector<fs::path> usable;
  for (const fs::path& folder : network_folders()) {
    ROOMWISE_TRY(const auto files, list_networks(folder, is_for));
    for (const fs::path& file : files) {
      const bool hidden = std::ranges::any_of(
          usable, [&](const fs::path& other) { return other.filename() == file.filename(); });
      if (!hidden) usable.push_back(file);
    }
  }
  return usable;
}

void sort_by_size(std::vector<fs::path>& files) {
  std::ranges::stable_sort(files, {}, [](const fs::path& file) {
    std::error_code ignored;
    return fs::file_size(file, ignored);
  });
}

// The smallest classifier of the folders that names such things looks closer beside the detector.
Expected<void> add_closer_looks(objects::ObjectFinders& all,
                                const std::shared_ptr<const network::Detector>& detector) {
  ROOMWISE_TRY(auto files, networks_for(classifies));
  sort_by_size(files);
  const auto vocabulary = objects::ObjectVocabulary::standard();
  for (const fs::path& file : files) {
    const auto card = network::find_model_card(file);
    if (!card || card->labels_file.empty()) continue;
    auto whole = network::OnnxClassifier::load(file);
    if (!whole) {
      fmt::print(stderr, "left out: {}\n", whole.error().message);
      continue;
    }
    const auto words = objects::classes_with_labels(vocabulary, (*whole)->labels(),
                                                    [](const std::string&) { return true; });
    if (words.objects().empty()) continue;  // it names other things: rooms, or animals
    const std::shared_ptr<const network::Classifier> classifier = *std::move(whole);
    all.of_proposals = objects::network_proposal_classifier(detector, classifier);
    return {};
  }
  return {};
}

// The files that the options name, or those that are used where they name none.
struct ChosenFiles {
  std::vector<fs::path> files;
  bool are_defaults = false;
};

Expected<ChosenFiles> choose_files(const NetworkOptions& options, bool also_brought) {
  if (options.labels && options.files.empty())
    return fail("--labels says what a --network can name; give that too");
  std::vector<fs::path> files = options.files;
  for (fs::path& file : files) {
    std::error_code ignored;
    if (fs::exists(file, ignored)) continue;  // a file, or a name as "networks list" says it
    ROOMWISE_TRY(file, find_network_file(file.string()));
  }
  const bool are_defaults = files.empty();
  if (are_defaults) {
    ROOMWISE_TRY(files, usable_networks());
  }
  const auto brought = brought_network_folder();
  const bool is_brought = are_defaults && !files.empty() && files.front().parent_path() == brought;
  if (is_brought) {
    fmt::print(stderr,
               "no other network is installed: {} looks at the pictures, which has learned from "
               "simulated homes alone\n",
               files.front().stem().string());
  }
  if (are_defaults && also_brought && brought && !is_brought) {
    ROOMWISE_TRY(const auto more, list_networks(*brought, classifies));
    files.insert(files.end(), more.begin(), more.end());
  }
  return ChosenFiles{std::move(files), are_defaults};
}

// --labels is the last one's.
std::optional<fs::path> labels_for(const NetworkOptions& options, const ChosenFiles& chosen,
                                   const fs::path& file) {
  return &file == &chosen.files.back() ? options.labels : std::nullopt;
}

Expected<std::unique_ptr<network::OnnxClassifier>> load_network(
    const fs::path& file, const std::optional<fs::path>& labels,
    pipeline::NetworkPrecision precision, const home::Home* home) {
  ROOMWISE_TRY(network::NetworkFile read, network::read_network_file(file, labels));
  if (home != nullptr) {
    ROOMWISE_TRY(read, pipeline::known_as_before(*home, std::move(read), file));
    ROOMWISE_TRY(read, pipeline::in_precision(*home, std::move(read), precision));
  }
  return network::OnnxClassifier::create(std::move(read), file);
}

// The program, or the shared library that this is compiled into: Python's.
fs::path file_of_this_code() {
  static const char in_this_code = 0;
  Dl_info info{};
  if (dladdr(&in_this_code, &info) != 0 && fs::path(info.dli_fname).extension() == ".so") {
    return fs::absolute(info.dli_fname);
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program;
}

}  // namespace

Expected<fs::path> own_network_folder() {
  const auto variable = [](const char* name) -> fs::path {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  // A path that is not absolute is to be taken for none (XDG Base Directory Specification).
  fs::path data = variable("XDG_DATA_HOME");
  if (!data.is_absolute() && variable("HOME").is_absolute()) {
    data = variable("HOME") / ".local" / "share";
  }
  if (!data.is_absolute()) {
    return fail("neither XDG_DATA_HOME nor HOME names a folder to keep networks in; give --to");
  }
  return data / "roomwise" / "networks";
}

std::vector<fs::path> network_folders() {
  std::vector<fs::path> folders;
  if (const auto folder = network::default_model_folder()) folders.push_back(*folder);
  const auto own = own_network_folder();
  std::error_code ignored;
  if (own && fs::is_directory(*own, ignored)) folders.push_back(*own);
  return folders;
}

std::optional<fs::path> brought_network_folder() {
  // Beside bin/ of a build or of an installation; a Python package lies deeper, in folders of its
  // own.
  const fs::path code = file_of_this_code();
  const int max_depth = code.extension() == ".so" ? 5 : 2;
  std::error_code ignored;
  fs::path prefix = code.parent_path();
  for (int depth = 1; depth < max_depth && prefix.has_relative_path(); ++depth) {
    prefix = prefix.parent_path();
    const fs::path folder = prefix / "share" / "roomwise" / "networks";
    if (fs::is_directory(folder, ignored)) return folder;
  }
  return std::nullopt;
}

Expected<std::vector<fs::path>> usable_networks() {
  ROOMWISE_TRY(auto usable, networks_for(classifies));
  const auto brought = brought_network_folder();
  if (usable.empty() && brought) {
    ROOMWISE_TRY(usable, list_networks(*brought, classifies));
  }
  return usable;
}

Expected<std::vector<fs::path>> usable_detectors() {
  ROOMWISE_TRY(auto files, networks_for(network::finds_things));
  sort_by_size(files);
  std::ranges::reverse(files);
  std::ranges::stable_partition(files, [](const fs::path& file) {
    const auto card = network::find_model_card(file);
    return card && card->task == network::Task::kNanoDetPlus;
  });
  std::vector<fs::path> usable;
  std::set<std::vector<std::string>> known;
  for (const fs::path& file : files) {
    const auto labels = network::read_labels_of(file);
    // Loading says what is wrong with one that cannot be read.
    if (!labels || known.insert(*labels).second) usable.push_back(file);
  }
  return usable;
}

Expected<std::vector<fs::path>> usable_word_networks() {
  return networks_for(matches_words);
}

Expected<std::unique_ptr<network::OpenVocabulary>> load_open_vocabulary() {
  ROOMWISE_TRY(const auto files, usable_word_networks());
  if (!files.empty()) return network::OpenVocabulary::load(files.front());
  const auto own = own_network_folder();
  return fail(
      "no pair of networks that compares pictures with words is here, and none can be pulled: put "
      "one of CLIP's kind into {}, as ONNX files of pictures and of texts, its list of pairs "
      "(bpe_simple_vocab_16e6.txt), and a card of the task \"match-words\"; the manual shows one "
      "(Objects, \"Words that no label has\")",
      own ? own->string() : "a folder of networks (ROOMWISE_MODELS)");
}

std::vector<fs::path> installed_networks() {
  std::vector<fs::path> folders = network_folders();
  if (const auto brought = brought_network_folder()) folders.push_back(*brought);
  std::map<fs::path, fs::path> first;  // by the file's name
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const fs::path& file = entry.path();
      if (network::has_ending_of_network(file) || network::is_eight_bit_file(file))
        first.try_emplace(file.filename(), file);
    }
  }
  const auto files = std::views::values(first);
  return {files.begin(), files.end()};
}

const network::CatalogueEntry* find_catalogue_entry(const std::string& name) {
  const auto& entries = network::catalogue();
  const auto found = std::ranges::find_if(entries, [&](const network::CatalogueEntry& entry) {
    return entry.name == name || entry.file == name;
  });
  return found == entries.end() ? nullptr : &*found;
}

std::optional<fs::path> find_in_folders(const std::string& file) {
  std::error_code ignored;
  std::vector<fs::path> folders = network_folders();
  if (const auto brought = brought_network_folder()) folders.push_back(*brought);
  for (const fs::path& folder : folders) {
    if (fs::is_regular_file(folder / file, ignored)) return folder / file;
  }
  return std::nullopt;
}

Expected<fs::path> find_network_file(const std::string& name) {
  std::error_code ignored;
  if (const network::CatalogueEntry* entry = find_catalogue_entry(name)) {
    if (const auto file = find_in_folders(entry->file)) return *file;
    return fail("{}: is not here yet; fetch it by 'roomwise networks pull {}'", name, entry->name);
  }
  for (const std::string& file : {name, name + ".onnx", name + ".safetensors", name + ".pth",
                                  name + network::EightBitFile::kEnding}) {
    if (const auto found = find_in_folders(file)) return *found;
  }
  if (fs::is_regular_file(name, ignored)) return name;
  return fail("{}: no such network; 'roomwise networks list' names those that there are", name);
}

void add_precision_option(CLI::App& command, NetworkOptions& options) {
  command
      .add_option_function<std::string>(
          "--network-precision",
          [&options](const std::string& name) {
            options.precision = *pipeline::parse_network_precision(name);
          },
          "How networks that serve features, and name nothing, look at this home's pictures: auto "
          "(in 8 bits where a check on 80 of the home's own pictures allowed that, and as its "
          "rooms were learned), float, or eight-bits; all others look in floats. What was learned "
          "in one is not asked in the other [auto]")
      ->check(CLI::IsMember({"auto", "float", "eight-bits"}));
}

void add_network_options(CLI::App& command, NetworkOptions& options) {
  command.add_option("--network", options.files,
                     "ONNX network, or weights (.pth, .safetensors) of a known one, with its card "
                     "NAME.card.json beside it, or one in 8 bits (.eightbits, networks quantize), "
                     "or the name of one that is here (networks list). Detectors look at "
                     "key-frames by themselves. May be given several times. Without it: "
                     "those of ROOMWISE_MODELS, else of ../shared/models, and those of the "
                     "user's own folder; where neither holds one, the compact network that comes "
                     "with Roomwise (roomwise networks list)");
  command.add_option("--labels", options.labels,
                     "What the last --network can name, a label a line, in place of the card's");
  add_precision_option(command, options);
}

Expected<pipeline::Networks> load_networks(const NetworkOptions& options, const home::Home* home,
                                           bool also_brought) {
  ROOMWISE_TRY(const ChosenFiles chosen, choose_files(options, also_brought));
  pipeline::Networks networks;
  for (const fs::path& file : chosen.files) {
    auto loaded = load_network(file, labels_for(options, chosen, file), options.precision, home);
    if (loaded) {
      networks.push_back(*std::move(loaded));
    } else if (chosen.are_defaults && options.precision != pipeline::NetworkPrecision::kEightBits) {
      // One that nobody asked for must not end work that the others can do.
      fmt::print(stderr, "left out: {}\n", loaded.error().message);
    } else {
      return Unexpected(std::move(loaded).error());
    }
  }
  if (home != nullptr) {
    ROOMWISE_TRY(const auto changed, pipeline::changed_networks(*home, networks, {}));
    for (const auto& one : changed) {
      fmt::print(stderr, "{}\n", pipeline::in_words(one, home->file()));
    }
  }
  return networks;
}

Expected<pipeline::Networks> load_networks_for_new(const NetworkOptions& options, home::Home& home,
                                                   std::size_t pictures,
                                                   const network::PictureAt& picture,
                                                   Context& context) {
  ROOMWISE_TRY(const ChosenFiles chosen, choose_files(options, /*also_brought=*/false));
  for (const fs::path& file : chosen.files) {
    const auto card = network::find_model_card(file);
    const auto labels = labels_for(options, chosen, file);
    if (!card || !card->labels_file.empty() || labels) continue;  // it names things: in floats
    auto read = network::read_network_file(file, labels);
    if (!read) continue;  // loading it says why
    ROOMWISE_TRY(read, pipeline::known_as_before(home, *std::move(read), file));
    ROOMWISE_TRY(const bool is_new,
                 pipeline::needs_precision_check(home, *read, options.precision));
    if (!is_new) continue;
    constexpr const char* kWork = "checking whether 8 bits will do";
    const auto shown = [&](std::size_t i) -> Expected<image::ColorImage> {
      ROOMWISE_RETURN_IF_ERROR(context.progress.check(kWork));
      return picture(i);
    };
    std::size_t last_of = 0;  // a second try is work of its own
    const auto runs_done = [&](std::size_t done, std::size_t of) -> Expected<void> {
      if (of != last_of) context.progress.begin(kWork, of);
      last_of = of;
      context.progress.advance(done, "");
      return context.progress.check(kWork);
    };
    ROOMWISE_TRY(
        const pipeline::PrecisionCheck check,
        pipeline::check_precision(home, file, pictures, shown, context.threads, runs_done));
    if (last_of > 0) context.progress.end();
    context.progress.note(fmt::format("{} looks at this home in {}: {}", card->name,
                                      check.eight_bits ? "8 bits" : "floats", check.why));
  }
  return load_networks(options, &home);
}

Expected<pipeline::Networks> load_networks_for_keyframes(const NetworkOptions& options,
                                                         home::Home& home, Context& context) {
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  const std::size_t count = keyframes.size();
  return load_networks_for_new(options, home, count,
                               pictures_of_keyframes(home, std::move(keyframes)), context);
}

network::PictureAt pictures_of_keyframes(const home::Home& home,
                                         std::vector<home::Keyframe> keyframes) {
  return [&home, keyframes = std::move(keyframes)](std::size_t i) -> Expected<image::ColorImage> {
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframes[i].id));
    return image::decode_color(images.color).map_error([&](Error error) {
      return std::move(error).with_context(
          fmt::format("{}: key-frame {}", home.file(), keyframes[i].id));
    });
  };
}

Expected<objects::ObjectFinders> load_object_finders() {
  ROOMWISE_TRY(const auto files, usable_detectors());
  objects::ObjectFinders finders;
  std::shared_ptr<const network::Detector> first;
  for (const fs::path& file : files) {
    if (auto loaded = network::Detector::load(file)) {
      const std::shared_ptr<const network::Detector> detector = *std::move(loaded);
      if (first == nullptr) first = detector;
      finders.in_pictures.push_back(objects::detector_finder(file.stem().string(), detector));
    } else {
      // One that nobody asked for must not end work that the others can do.
      fmt::print(stderr, "left out: {}\n", loaded.error().message);
    }
  }
  if (first != nullptr) ROOMWISE_RETURN_IF_ERROR(add_closer_looks(finders, first));
  return finders;
}

}  // namespace roomwise::app
