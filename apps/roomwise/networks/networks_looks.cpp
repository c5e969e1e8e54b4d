// Of "networks": what a network is, and what it costs here.

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>

#include "commands.h"
#include "networks.h"
#include "roomwise/base/random.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/network/vision/open_vocabulary.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using network::CatalogueEntry;

struct LookOptions {
  std::string name;
  int runs = 20;  // of bench
};

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

Expected<Answer> info(const LookOptions& options, Context& /*context*/) {
  const std::string& name = options.name;
  Answer answer;
  const CatalogueEntry* entry = find_catalogue_entry(name);
  const auto file = find_network_file(name);
  if (!file && entry == nullptr) return Unexpected(file.error());
  if (entry == nullptr) entry = find_catalogue_entry(file->filename().string());
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
                           {"source", card->source},
                           {"notes", card->notes}};
    for (const std::string& note : card->notes)
      answer.text += fmt::format("            {}\n", note);
  }
  if (network::is_eight_bit_file(*file)) {
    ROOMWISE_TRY(const auto how, network::read_eight_bit_file(*file));
    answer.text +=
        fmt::format("in 8 bits:  {}\n            {}\n", how.network.string(), how.checked);
    answer.json["eight_bits"] = {{"network", how.network.string()}, {"checked", how.checked}};
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
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
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

Expected<Answer> bench(const LookOptions& options, Context& /*context*/) {
  ROOMWISE_TRY(const fs::path file, find_network_file(options.name));
  ROOMWISE_TRY(const network::ModelCard card, network::find_model_card(file));
  const image::ColorImage picture = noise(card.input_width_px, card.input_height_px);
  const std::size_t before = resident_bytes();
  const double load_start_s = thread_cpu_time_s();
  std::function<Expected<void>()> look;
  if (card.task == network::Task::kMatchWords) {
    ROOMWISE_TRY(std::shared_ptr<network::OpenVocabulary> loaded,
                 network::OpenVocabulary::load(file));
    look = [loaded, &picture]() -> Expected<void> {
      ROOMWISE_TRY(const auto embedding, loaded->embed(picture));
      return {};
    };
  } else if (!network::finds_things(card.task)) {
    ROOMWISE_TRY(std::shared_ptr<network::OnnxClassifier> loaded,
                 network::OnnxClassifier::load(file));
    look = [loaded, &picture]() -> Expected<void> {
      ROOMWISE_TRY(const auto prediction, loaded->predict(picture));
      return {};
    };
  } else {
    ROOMWISE_TRY(std::shared_ptr<network::Detector> loaded, network::Detector::load(file));
    look = [loaded, &picture]() -> Expected<void> {
      ROOMWISE_TRY(const auto things, loaded->detect(picture, 0.5F));
      return {};
    };
  }
  ROOMWISE_RETURN_IF_ERROR(look());
  const double first_ms = 1e3 * (thread_cpu_time_s() - load_start_s);
  std::vector<double> ms;
  for (int i = 0; i < options.runs; ++i) {
    const double start_s = thread_cpu_time_s();
    ROOMWISE_RETURN_IF_ERROR(look());
    ms.push_back(1e3 * (thread_cpu_time_s() - start_s));
  }
  std::ranges::sort(ms);
  const double median_ms = ms[ms.size() / 2];
  const double memory_mb = static_cast<double>(resident_bytes() - before) / (1 << 20);
  return Answer{
      fmt::format(
          "{}: {:.1f} ms a picture (median of {}; {:.1f} to {:.1f}), processor time of one thread\n"
          "from the file to the first result {:.0f} ms, {:.0f} MB\n",
          card.name, median_ms, options.runs, ms.front(), ms.back(), first_ms, memory_mb),
      {{"file", file.string()},
       {"cpu_ms", median_ms},
       {"least_cpu_ms", ms.front()},
       {"most_cpu_ms", ms.back()},
       {"runs", options.runs},
       {"first_result_cpu_ms", first_ms},
       {"memory_mb", memory_mb}}};
}

}  // namespace

void add_networks_looks(CLI::App& group, Context& context) {
  const auto add = [&](const char* name, const char* description, const char* example, auto body) {
    const auto declared =
        add_command<LookOptions>(group, context, name, description, example, body);
    declared.first->add_option("NAME", declared.second.name, "A name of the catalogue, or a file")
        ->required();
    return declared;
  };
  add("info", "What a network is: card, licence, layers, size", "roomwise networks info yolox-nano",
      info);
  const auto [command, options] = add("bench", "Time a network on this machine",
                                      "roomwise networks bench mobilenet-v2-imagenet", bench);
  add_setting(*command, "--runs", options.runs, "Pictures to look at", CLI::Range(1, 100'000));
}

}  // namespace roomwise::app
