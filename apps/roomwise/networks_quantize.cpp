// Of "networks": how a network is run in 8 bits, by a home's own pictures.

#include <algorithm>
#include <filesystem>
#include <memory>

#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/classifier_quantization.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using network::QuantizedClassifier;

struct QuantizeOptions {
  std::string name;
  fs::path home;
  fs::path pictures;
  fs::path out;
};

bool is_picture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png" || ending == ".webp";
}

// Of a folder and those in it, by name.
Expected<std::vector<fs::path>> pictures_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (is_picture(entry->path())) files.push_back(entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  std::ranges::sort(files);
  return files;
}

Expected<QuantizedClassifier> quantize(const fs::path& weights, const QuantizeOptions& options,
                                       const Context& context) {
  if (!options.pictures.empty()) {
    ROOMWISE_TRY(const auto files, pictures_of(options.pictures));
    return network::quantize_classifier(weights, files.size(),
                                        [&](std::size_t i) { return image::read_color(files[i]); })
        .map_error([&](Error error) { return std::move(error).in(options.pictures.string()); });
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const auto picture = [&](std::size_t i) -> Expected<image::ColorImage> {
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframes[i].id));
    return image::decode_color(images.color);
  };
  return network::quantize_classifier(weights, keyframes.size(), picture)
      .map_error([&](Error error) { return std::move(error).in(options.home.string()); });
}

Json report_of(const QuantizedClassifier& quantized) {
  const network::QuantizationReport& report = quantized.report;
  return {{"used", report.is_used},
          {"reason", report.reason},
          {"measured_on", quantized.measured_on},
          {"checked_on", quantized.checked_on},
          {"least_channels", report.least_channels},
          {"mean_cosine", report.mean_cosine},
          {"least_cosine", report.least_cosine},
          {"mean_error", report.mean_error},
          {"agreement", report.agreement}};
}

Expected<Answer> quantize_command(const QuantizeOptions& options, const Context& context) {
  ROOMWISE_TRY(const fs::path weights, find_network_file(options.name));
  fs::path out = options.out;
  if (out.empty())
    out = weights.parent_path() /
          (weights.stem().string() + "-8bit" + network::EightBitFile::kEnding);
  if (!network::is_eight_bit_file(out)) {
    return fail("{}: a file of 8 bits ends in {}", out.string(), network::EightBitFile::kEnding);
  }
  ROOMWISE_TRY(QuantizedClassifier quantized, quantize(weights, options, context));
  if (!quantized.report.is_used) {
    return fail("{}: 8 bits do not come near enough to floats: {}; nothing was written",
                weights.string(), quantized.report.reason);
  }
  const fs::path folder = out.has_parent_path() ? out.parent_path() : fs::path(".");
  std::error_code ignored;
  const fs::path beside = fs::proximate(weights, folder, ignored);
  quantized.file.network = beside.empty() ? fs::absolute(weights) : beside;
  ROOMWISE_CHECK_OK(write_file(out, text_of(quantized.file)));
  Answer answer;
  answer.text = fmt::format(
      "{}: {}\n{}use it by --network {}; what was learned in floats must be learned anew\n",
      out.string(), quantized.file.checked,
      quantized.report.least_channels > 1
          ? fmt::format("layers of fewer than {} channels stay in floats\n",
                        quantized.report.least_channels)
          : "",
      out.string());
  answer.json = report_of(quantized);
  answer.json["file"] = out.string();
  return answer;
}

}  // namespace

void add_networks_quantize(CLI::App& group, Context& context) {
  auto options = std::make_shared<QuantizeOptions>();
  CLI::App* command = add_command(
      group, context, "quantize",
      "Have a network that looks at whole pictures run in 8 bits, where that comes near enough",
      "roomwise networks quantize mobilenet-v2-imagenet --home flat.home",
      [options, &context] { return quantize_command(*options, context); });
  command->add_option("NAME", options->name, "A name of the catalogue, or a file")->required();
  CLI::Option* home =
      command->add_option("--home", options->home, "Measure it on the key-frames of this home");
  CLI::Option* pictures =
      command->add_option("--pictures", options->pictures, "Measure it on this folder's pictures")
          ->excludes(home);
  command->add_option("--out", options->out,
                      "File to write, NAME.eightbits; default: NAME-8bit.eightbits beside the "
                      "network");
  command->parse_complete_callback([home, pictures] {
    if (home->count() + pictures->count() == 0)
      throw CLI::RequiredError("--home or --pictures: what to measure it on");
  });
}

}  // namespace roomwise::app
