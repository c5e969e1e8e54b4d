// Of "networks": how a network is run in 8 bits, by a home's own pictures.

#include <filesystem>

#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/picture_files.h"
#include "roomwise/network/vision/classifier_quantization.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using network::QuantizedClassifier;

struct QuantizeOptions {
  std::string name;
  fs::path home;
  fs::path pictures;
  fs::path out;
  bool replaces = false;
};

Expected<QuantizedClassifier> quantize(const fs::path& weights, const QuantizeOptions& options,
                                       const Context& context) {
  if (!options.pictures.empty()) {
    ROOMWISE_TRY(const auto files, image::picture_files(options.pictures));
    return network::quantize_classifier(
        weights, files.size(), [&](std::size_t i) { return image::read_color(files[i]); },
        context.threads);
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  const std::size_t count = keyframes.size();
  return network::quantize_classifier(
      weights, count, pictures_of_keyframes(home, std::move(keyframes)), context.threads);
}

// How the file of 8 bits names its network: by the folders as they are, but by the network's own
// name, beside which its card and labels lie, also where that is a link.
fs::path beside(const fs::path& weights, const fs::path& out) {
  const auto folder_of = [](const fs::path& file) {
    return fs::canonical(file.has_parent_path() ? file.parent_path() : fs::path("."));
  };
  const fs::path between = folder_of(weights).lexically_proximate(folder_of(out));
  return (between / weights.filename()).lexically_normal();
}

// What is there counts as a network by what it says: homes were perhaps learned with it.
Expected<void> check_replaces(const QuantizeOptions& options, const fs::path& out,
                              const network::EightBitFile& made) {
  std::error_code ignored;
  if (options.replaces || !fs::exists(out, ignored)) return {};
  const auto there = network::read_eight_bit_file(out);
  if (there && there->fingerprint() == made.fingerprint()) return {};
  return fail(
      "{}: is there already, and runs the network otherwise; what was learned with it would have "
      "to be learned anew. Name another file by --out, or replace it by --replace",
      out.string());
}

Json report_of(const QuantizedClassifier& quantized) {
  const network::QuantizationReport& report = quantized.report;
  return {{"used", report.is_used},
          {"reason", report.reason},
          {"measured_on", quantized.measured_on},
          {"checked_on", quantized.checked_on},
          {"least_channels", report.min_channels},
          {"time_ratio", report.time_ratio},
          {"mean_cosine", report.mean_cosine},
          {"least_cosine", report.min_cosine},
          {"mean_error", report.mean_error},
          {"agreement", report.agreement}};
}

Expected<Answer> quantize_command(const QuantizeOptions& options, Context& context) {
  ROOMWISE_TRY(const fs::path weights, find_network_file(options.name));
  fs::path out = options.out;
  if (out.empty()) {
    ROOMWISE_TRY(const fs::path folder, own_network_folder());
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    out = folder / (weights.stem().string() + "-8bit" + network::EightBitFile::kEnding);
  }
  if (!network::is_eight_bit_file(out)) {
    return fail("{}: a file of 8 bits ends in {}", out.string(), network::EightBitFile::kEnding);
  }
  ROOMWISE_RETURN_IF_ERROR(check_can_write(out));
  ROOMWISE_TRY(QuantizedClassifier quantized, quantize(weights, options, context));
  if (!quantized.report.is_used) {
    return fail("{}: 8 bits do not come near enough to floats: {}; nothing was written",
                weights.string(), quantized.report.reason);
  }
  quantized.file.network = beside(weights, out);
  ROOMWISE_RETURN_IF_ERROR(check_replaces(options, out, quantized.file));
  ROOMWISE_TRY(const std::string text, network::text_of(quantized.file));
  ROOMWISE_RETURN_IF_ERROR(write_file(out, text));
  Answer answer;
  answer.text = fmt::format("{}: {}\n", weights.string(), quantized.file.checked);
  if (quantized.report.min_channels > 1) {
    answer.text += fmt::format("layers of fewer than {} channels stay in floats\n",
                               quantized.report.min_channels);
  }
  answer.text += fmt::format(
      "it takes {:.2f} of the processor time that it takes in floats (here, the fastest of three "
      "runs)\n"
      "use it by --network {}; rooms that were learned in floats must be learned anew with it\n",
      quantized.report.time_ratio, out.string());
  answer.json = report_of(quantized);
  answer.json["network"] = weights.string();
  answer.json["file"] = out.string();
  return answer;
}

}  // namespace

void add_networks_quantize(CLI::App& group, Context& context) {
  const auto [command, options] = add_command<QuantizeOptions>(
      group, context, "quantize",
      "Have a network that looks at whole pictures run in 8 bits, where that comes near enough",
      "roomwise networks quantize inception-2015-12-05-trunk --home flat.home", quantize_command);
  command->add_option("NAME", options.name, "A name of the catalogue, or a file")->required();
  CLI::Option* home =
      command->add_option("--home", options.home, "Measure it on the key-frames of this home");
  CLI::Option* pictures =
      command->add_option("--pictures", options.pictures, "Measure it on this folder's pictures")
          ->excludes(home);
  command->add_option("--out", options.out,
                      "File to write, NAME.eightbits; default: NAME-8bit.eightbits in the "
                      "user's own folder of networks");
  command->add_flag("--replace", options.replaces,
                    "Replace a file that is there, also by one that runs the network otherwise");
  command->parse_complete_callback([home, pictures] {
    if (home->count() + pictures->count() == 0)
      throw CLI::RequiredError("--home or --pictures: what to measure it on");
  });
}

}  // namespace roomwise::app
