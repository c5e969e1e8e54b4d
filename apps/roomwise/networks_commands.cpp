#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "commands.h"
#include "networks.h"
#include "roomwise/base/file.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/download/https_download.h"
#include "roomwise/network/catalogue.h"
#include "roomwise/network/detector.h"
#include "roomwise/network/network_file.h"
#include "roomwise/network/onnx_classifier.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using download::ExpectedFile;
using download::FetchedFile;
using network::CatalogueEntry;

const CatalogueEntry* find_entry(const std::string& name) {
  const auto& entries = network::catalogue();
  const auto found = std::ranges::find_if(entries, [&](const CatalogueEntry& entry) {
    return entry.name == name || entry.file == name;
  });
  return found == entries.end() ? nullptr : &*found;
}

// The first folder of networks that has this file.
std::optional<fs::path> find_in_folders(const std::string& file) {
  std::error_code ignored;
  for (const fs::path& folder : network_folders()) {
    if (fs::is_regular_file(folder / file, ignored)) return folder / file;
  }
  return std::nullopt;
}

// A network's file by what the user calls it: a name of the catalogue, a file of the folders of
// networks with or without its ending, or a path.
Expected<fs::path> find_file(const std::string& name) {
  std::error_code ignored;
  if (const CatalogueEntry* entry = find_entry(name)) {
    if (const auto file = find_in_folders(entry->file)) return *file;
    return fail("{}: is not here yet; fetch it by 'roomwise networks pull {}'", name, entry->name);
  }
  for (const std::string& file : {name, name + ".onnx"}) {
    if (const auto found = find_in_folders(file)) return *found;
  }
  if (fs::is_regular_file(name, ignored)) return name;
  return fail("{}: no such network; 'roomwise networks list' names those that there are", name);
}

// FILE.sha256 beside a file, as sha256sum writes it: what was fetched once.
fs::path record_of(const fs::path& file) {
  return file.string() + ".sha256";
}

std::string recorded_digest(const fs::path& file) {
  const auto text = read_text_file(record_of(file));
  if (!text) return {};
  const std::string digest = text->substr(0, text->find(' '));
  return digest.size() == 64 && download::is_digest_begin(digest) ? digest : std::string();
}

// ---- networks list ----

std::string what_for(const fs::path& file) {
  const auto card = network::find_model_card(file);
  if (!card) return "no card";
  if (card->task != network::Task::kClassify) return "finds things";
  return card->labels_file.empty() ? "features" : "features and names";
}

Expected<Answer> list() {
  Answer answer;
  answer.json = {{"folders", Json::array()}, {"here", Json::array()}, {"known", Json::array()}};
  ROOMWISE_TRY(const auto usable, usable_networks());
  for (const fs::path& folder : network_folders()) {
    answer.json["folders"].push_back(folder.string());
    answer.text += fmt::format("In {}:\n", folder.string());
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".onnx" || ending == ".pth" || ending == ".safetensors") {
        files.push_back(entry.path());
      }
    }
    std::ranges::sort(files);
    for (const fs::path& file : files) {
      const bool used = std::ranges::find(usable, file) != usable.end();
      const std::string purpose = what_for(file);
      answer.text += fmt::format("  {:44} {:20} {}\n", file.filename().string(), purpose,
                                 used ? "used by default" : "");
      answer.json["here"].push_back(
          {{"file", file.string()}, {"for", purpose}, {"used_by_default", used}});
    }
  }
  answer.text += "Published (roomwise networks pull NAME):\n";
  for (const CatalogueEntry& entry : network::catalogue()) {
    const auto file = find_in_folders(entry.file);
    answer.text += fmt::format("  {:28} {:10} {}\n", entry.name, file ? "here" : "", entry.about);
    answer.json["known"].push_back({{"name", entry.name},
                                    {"file", entry.file},
                                    {"address", entry.address},
                                    {"sha256_begin", entry.sha256_begin},
                                    {"license", entry.license},
                                    {"about", entry.about},
                                    {"installed", file ? Json(file->string()) : Json()}});
    if (entry.bytes) answer.json["known"].back()["bytes"] = *entry.bytes;
  }
  return answer;
}

// ---- networks pull ----

struct PullOptions {
  std::string name;
  fs::path to;
  std::string from;
  std::string sha256;
  fs::path certificates;
};

// Fetches an entry's file from where the user says, or from its publisher.
Expected<FetchedFile> fetch(const CatalogueEntry& entry, const PullOptions& options,
                            const fs::path& target, const ExpectedFile& expected,
                            Context& context) {
  const std::string& from = options.from;
  if (from.empty() || from.find("://") != std::string::npos) {
    std::string url = from.empty() ? entry.address : from;
    if (url.ends_with('/')) url += entry.file;  // a mirror
    download::DownloadOptions download_options;
    download_options.certificates = options.certificates;
    return download::download(url, target, expected, context.progress, download_options);
  }
  std::error_code ignored;
  const fs::path source =
      fs::is_directory(from, ignored) ? from / fs::path(entry.file) : fs::path(from);
  return download::copy_checked(source, target, expected);
}

Expected<Answer> pull(const PullOptions& options, Context& context) {
  const CatalogueEntry* entry = find_entry(options.name);
  if (entry == nullptr) {
    return fail("{}: is not in the catalogue; 'roomwise networks list' names what is",
                options.name);
  }
  if (!options.sha256.empty() &&
      (options.sha256.size() != 64 || !download::is_digest_begin(options.sha256))) {
    return fail("--sha256 is not a digest: expected 64 lower-case hexadecimal digits");
  }
  fs::path folder = options.to;
  if (folder.empty()) {
    ROOMWISE_TRY(folder, own_network_folder());
  }
  const fs::path target = folder / entry->file;
  // What the user says of the digest counts more than what the catalogue has from others.
  const bool own_digest = !options.sha256.empty();
  const ExpectedFile expected{own_digest ? std::nullopt : entry->bytes,
                              own_digest ? options.sha256 : entry->sha256_begin};
  Expected<FetchedFile> fetched = download::check_file(target, expected);
  const bool was_here = fetched.has_value() && (!expected.sha256_begin.empty() ||
                                                fetched->sha256 == recorded_digest(target));
  if (!was_here) {
    fetched = fetch(*entry, options, target, expected, context);
    if (!fetched) return Unexpected(std::move(fetched).error());
    ROOMWISE_CHECK_OK(
        write_file(record_of(target), fmt::format("{}  {}\n", fetched->sha256, entry->file)));
  }
  Answer answer;
  answer.text = fmt::format("{}: {} bytes, {}\n", target.string(), fetched->bytes,
                            was_here ? "was here already" : "fetched");
  answer.text += fmt::format("SHA-256 {}\n", fetched->sha256);
  std::string checked_by = own_digest ? "--sha256" : entry->digest_from;
  if (checked_by.empty()) {
    answer.text +=
        "warning: nobody has published its digest, so that only the connection vouches for it; "
        "compare it with that of a copy you trust. It is recorded for 'networks verify'\n";
  } else {
    answer.text +=
        fmt::format("checked: {} digits, from {}\n", expected.sha256_begin.size(), checked_by);
  }
  answer.text += fmt::format("licence: {}\n", entry->license);
  answer.json = {{"file", target.string()},
                 {"bytes", fetched->bytes},
                 {"sha256", fetched->sha256},
                 {"digits_checked", expected.sha256_begin.size()},
                 {"digest_from", checked_by},
                 {"was_here", was_here},
                 {"resumed_from", fetched->resumed_from},
                 {"license", entry->license}};
  return answer;
}

// ---- networks verify ----

struct VerifyOptions {
  std::vector<std::string> names;
};

// The files to check: those named, or all of the catalogue that are here.
Expected<std::vector<fs::path>> files_to_verify(const VerifyOptions& options) {
  std::vector<fs::path> files;
  for (const std::string& name : options.names) {
    ROOMWISE_TRY(fs::path file, find_file(name));
    files.push_back(std::move(file));
  }
  if (!options.names.empty()) return files;
  for (const CatalogueEntry& entry : network::catalogue()) {
    if (auto file = find_in_folders(entry.file)) files.push_back(*std::move(file));
  }
  if (files.empty()) return fail("no network of the catalogue is here; name one, or pull one");
  return files;
}

Expected<Answer> verify(const VerifyOptions& options) {
  ROOMWISE_TRY(const auto files, files_to_verify(options));
  Answer answer;
  answer.json = Json::array();
  std::vector<std::string> wrong;
  for (const fs::path& file : files) {
    const CatalogueEntry* entry = find_entry(file.filename().string());
    const std::string recorded = recorded_digest(file);
    ExpectedFile expected{entry != nullptr ? entry->bytes : std::nullopt,
                          entry != nullptr ? entry->sha256_begin : ""};
    // What was fetched once says more than the first digits, if it agrees with them.
    if (recorded.starts_with(expected.sha256_begin)) expected.sha256_begin = recorded;
    const auto checked = download::check_file(file, expected);
    if (!checked) wrong.push_back(checked.error().message);
    const std::string state = !checked ? "WRONG"
                              : expected.sha256_begin.empty()
                                  ? "nothing is known to compare with"
                                  : fmt::format("right ({} digits)", expected.sha256_begin.size());
    answer.text += fmt::format("{}: {}\n", file.string(), state);
    answer.json.push_back({{"file", file.string()},
                           {"right", checked.has_value()},
                           {"digits_checked", expected.sha256_begin.size()}});
    if (checked) answer.json.back()["sha256"] = checked->sha256;
  }
  if (!wrong.empty()) return fail("{}; delete it and pull it again", fmt::join(wrong, "; "));
  return answer;
}

// ---- networks info ----

Json inputs_of(const network::OnnxGraph& graph) {
  Json inputs = Json::array();
  for (const auto& input : graph.inputs) {
    inputs.push_back({{"name", input.name}, {"shape", network::shape_text(input.shape)}});
  }
  return inputs;
}

void describe_graph(const network::NetworkFile& file, Answer& answer) {
  std::size_t parameters = 0;
  for (const auto& [name, constant] : file.graph.constants) parameters += constant->floats.size();
  std::map<std::string, std::size_t> operators;
  for (const auto& node : file.graph.nodes) ++operators[node.operation];
  std::vector<std::string> counted;
  for (const auto& [operation, count] : operators) {
    counted.push_back(fmt::format("{} {}", count, operation));
  }
  answer.json["inputs"] = inputs_of(file.graph);
  answer.json["outputs"] = file.graph.outputs;
  answer.json["opset"] = file.graph.opset;
  answer.json["layers"] = operators;
  answer.json["parameters"] = parameters;
  answer.json["parameter_bytes"] = 4 * parameters;
  for (const auto& input : file.graph.inputs) {
    answer.text += fmt::format("input:      {} {}\n", input.name, network::shape_text(input.shape));
  }
  answer.text += fmt::format("outputs:    {}\n", fmt::join(file.graph.outputs, ", "));
  answer.text += fmt::format("layers:     {} as written (opset {}): {}\n", file.graph.nodes.size(),
                             file.graph.opset, fmt::join(counted, ", "));
  answer.text +=
      fmt::format("parameters: {} ({:.1f} MB in memory; 'networks bench' measures all)\n",
                  parameters, 4e-6 * static_cast<double>(parameters));
  answer.text += fmt::format("labels:     {}\n", file.labels.size());
}

Expected<Answer> info(const std::string& name) {
  Answer answer;
  const CatalogueEntry* entry = find_entry(name);
  const auto file = find_file(name);
  if (!file && entry == nullptr) return Unexpected(file.error());
  if (entry == nullptr) entry = find_entry(file->filename().string());
  if (entry != nullptr) {
    answer.text += fmt::format("{}: {}\npublished:  {}\nlicence:    {}\n", entry->name,
                               entry->about, entry->address, entry->license);
    answer.json["name"] = entry->name;
    answer.json["about"] = entry->about;
    answer.json["address"] = entry->address;
    answer.json["license"] = entry->license;
    answer.json["sha256_begin"] = entry->sha256_begin;
    answer.json["digest_from"] = entry->digest_from;
  }
  answer.json["installed"] = file.has_value();
  if (!file) {
    answer.text += fmt::format("not here; 'roomwise networks pull {}' fetches it\n", entry->name);
    return answer;
  }
  answer.json["file"] = file->string();
  answer.text += fmt::format("file:       {}\n", file->string());
  if (const auto card = network::find_model_card(*file)) {
    answer.text +=
        fmt::format("card:       {}, {}x{} pixels, {}\nsource:     {}\n", card->name,
                    card->input_width_px, card->input_height_px, card->license, card->source);
    answer.json["card"] = {{"name", card->name},
                           {"width_px", card->input_width_px},
                           {"height_px", card->input_height_px},
                           {"license", card->license},
                           {"source", card->source}};
  }
  const auto read = network::read_network_file(*file, std::nullopt);
  if (read) {
    describe_graph(*read, answer);
  } else {
    answer.text += fmt::format("cannot be run: {}\n", read.error().message);
    answer.json["problem"] = read.error().message;
  }
  return answer;
}

// ---- networks bench ----

// Memory of this process, bytes of physical memory.
std::size_t resident_bytes() {
  std::size_t all = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * 4096;
}

// Grey noise: a network's time does not depend on what it sees.
image::ColorImage noise(int width_px, int height_px) {
  RandomStream random(1);
  image::ColorImage image(width_px, height_px);
  for (Rgb8& pixel : image.pixels()) {
    const auto value = static_cast<std::uint8_t>(random.next());
    pixel = {value, value, value};
  }
  return image;
}

Expected<Answer> bench(const std::string& name, int runs) {
  ROOMWISE_TRY(const fs::path file, find_file(name));
  ROOMWISE_TRY(const network::ModelCard card, network::find_model_card(file));
  const image::ColorImage picture = noise(card.input_width_px, card.input_height_px);
  const std::size_t before = resident_bytes();
  const double load_start_s = thread_cpu_time_s();
  std::function<Expected<void>()> look;
  if (card.task == network::Task::kClassify) {
    ROOMWISE_TRY(std::shared_ptr<network::OnnxClassifier> loaded,
                 network::OnnxClassifier::load(file));
    look = [loaded, &picture]() -> Expected<void> {
      ROOMWISE_TRY(const auto prediction, loaded->predict(picture));
      return {};
    };
  } else {
    ROOMWISE_TRY(std::shared_ptr<network::Detector> loaded, network::Detector::load(file));
    look = [loaded, &picture]() -> Expected<void> {
      ROOMWISE_TRY(const auto things, loaded->detect(picture));
      return {};
    };
  }
  ROOMWISE_CHECK_OK(look());
  const double first_ms = 1e3 * (thread_cpu_time_s() - load_start_s);
  std::vector<double> ms;
  for (int i = 0; i < runs; ++i) {
    const double start_s = thread_cpu_time_s();
    ROOMWISE_CHECK_OK(look());
    ms.push_back(1e3 * (thread_cpu_time_s() - start_s));
  }
  std::ranges::sort(ms);
  const double median_ms = ms[ms.size() / 2];
  const double memory_mb = static_cast<double>(resident_bytes() - before) / (1 << 20);
  Answer answer;
  answer.text = fmt::format(
      "{}: {:.1f} ms a picture (median of {}; {:.1f} to {:.1f}), processor time of one thread\n"
      "from the file to the first result {:.0f} ms, {:.0f} MB\n",
      card.name, median_ms, runs, ms.front(), ms.back(), first_ms, memory_mb);
  answer.json = {
      {"file", file.string()},    {"cpu_ms", median_ms}, {"least_cpu_ms", ms.front()},
      {"most_cpu_ms", ms.back()}, {"runs", runs},        {"first_result_cpu_ms", first_ms},
      {"memory_mb", memory_mb}};
  return answer;
}

}  // namespace

void add_networks_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "networks", "Fetch, check and look at networks", "roomwise networks list");
  add_command(*group, context, "list", "Networks that are here, and published ones",
              "roomwise networks list", [] { return list(); });
  {
    auto options = std::make_shared<PullOptions>();
    CLI::App* command = add_command(*group, context, "pull", "Fetch a published network",
                                    "roomwise networks pull yolox-nano",
                                    [options, &context] { return pull(*options, context); });
    command->add_option("NAME", options->name, "As 'networks list' names it")->required();
    command->add_option("--to", options->to, "Folder to put it in; default: the user's own");
    command->add_option(
        "--from", options->from,
        "Take it from this file, folder, https address, or mirror (an https address "
        "that ends in /)");
    command->add_option("--sha256", options->sha256,
                        "Its digest, from whom you trust; takes the place of the catalogue's");
    command->add_option("--certificates", options->certificates,
                        "Trust the certificates of this PEM file in place of the system's");
  }
  {
    auto options = std::make_shared<VerifyOptions>();
    CLI::App* command =
        add_command(*group, context, "verify", "Check the files of networks again",
                    "roomwise networks verify", [options] { return verify(*options); });
    command->add_option("NAMES", options->names, "Default: all of the catalogue that are here");
  }
  {
    auto name = std::make_shared<std::string>();
    CLI::App* command =
        add_command(*group, context, "info", "What a network is: card, licence, layers, size",
                    "roomwise networks info yolox-nano", [name] { return info(*name); });
    command->add_option("NAME", *name, "A name of the catalogue, or a file")->required();
  }
  {
    auto name = std::make_shared<std::string>();
    auto runs = std::make_shared<int>(20);
    CLI::App* command = add_command(*group, context, "bench", "Time a network on this machine",
                                    "roomwise networks bench mobilenet-v2-imagenet",
                                    [name, runs] { return bench(*name, *runs); });
    command->add_option("NAME", *name, "A name of the catalogue, or a file")->required();
    command->add_option("--runs", *runs, "Pictures to look at")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
  }
}

}  // namespace roomwise::app
