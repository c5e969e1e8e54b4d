#include "roomwise/network/formats/eight_bit_file.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/network_file.h"

namespace roomwise::network {
namespace {

using Json = nlohmann::json;

constexpr std::int64_t kMaxSide = 4096;
constexpr std::int64_t kMaxChannels = 1 << 20;

bool is_whole(const Json& value, std::int64_t least, std::int64_t most) {
  return value.is_number_integer() && value >= least && value <= most;
}

Expected<ActivationRange> range_of(const Json& value) {
  const bool are_numbers =
      value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number();
  if (!are_numbers) return fail("expected the least and the largest number");
  const double least = value[0].get<double>(), most = value[1].get<double>();
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (!(least >= -kLargest && most <= kLargest && least <= most))
    return fail("{} to {} is no range", least, most);
  return ActivationRange{static_cast<float>(least), static_cast<float>(most)};
}

Expected<EightBitFile> file_of(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    static constexpr std::array kKnown{"network", "sha256",  "preprocessing", "input",
                                       "ranges",  "checked", "min_channels"};
    if (std::ranges::find(kKnown, key) == kKnown.end())
      return fail("{}: unknown field; known are {}", key, fmt::join(kKnown, ", "));
  }
  EightBitFile file;
  for (const char* key : {"network", "sha256", "preprocessing", "checked"}) {
    if (!json.contains(key) || !json.at(key).is_string())
      return fail("{}: expected a text in quotes", key);
  }
  file.network = json.at("network").get<std::string>();
  if (!has_ending_of_network(file.network))
    return fail("network: expected the file of a network's weights (.onnx, .pth, .safetensors)");
  file.sha256 = json.at("sha256").get<std::string>();
  file.preprocessing = json.at("preprocessing").get<std::string>();
  file.checked = json.at("checked").get<std::string>();
  const Json& input = json.contains("input") ? json.at("input") : Json();
  const auto is_side = [](const Json& side) { return is_whole(side, 1, kMaxSide); };
  if (!input.is_array() || input.size() != 4 || !std::ranges::all_of(input, is_side))
    return fail("input: expected four whole numbers: batch, channels, height, width");
  file.ranges.input = input.get<Shape>();
  if (!json.contains("min_channels") || !is_whole(json.at("min_channels"), 1, kMaxChannels))
    return fail("min_channels: expected a whole number from 1 on");
  file.ranges.min_channels = json.at("min_channels");
  if (!json.contains("ranges") || !json.at("ranges").is_object())
    return fail("ranges: expected {{ layer: [least, largest], ... }}");
  for (const auto& item : json.at("ranges").items()) {
    ROOMWISE_TRY(
        file.ranges.of_layers[item.key()], range_of(item.value()).map_error([&](Error error) {
          return std::move(error).with_context(fmt::format("ranges: layer \"{}\"", item.key()));
        }));
  }
  return file;
}

}  // namespace

bool is_eight_bit_file(const std::filesystem::path& file) {
  return file.extension() == EightBitFile::kEnding;
}

std::string name_in_eight_bits(const std::string& network) {
  return network + " (8 bits)";
}

Expected<EightBitFile> parse_eight_bit_file(std::string_view json, const std::string& origin) {
  const Json parsed = Json::parse(json, nullptr, false);
  if (!parsed.is_object()) return fail("{}: is not JSON that says how 8 bits are used", origin);
  return file_of(parsed).map_error(
      [&](Error error) { return std::move(error).with_context(origin); });
}

Expected<EightBitFile> read_eight_bit_file(const std::filesystem::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  return parse_eight_bit_file(text, file.string());
}

std::string EightBitFile::fingerprint() const {
  std::string text = fmt::format("{} {} {} {}", sha256, preprocessing, shape_text(ranges.input),
                                 ranges.min_channels);
  for (const auto& [layer, range] : ranges.of_layers)
    text += fmt::format("\n{}:{} {} {}", layer.size(), layer, range.least, range.most);
  return sha256_hex(Bytes(text.begin(), text.end()));
}

Expected<std::string> text_of(const EightBitFile& file) {
  using OrderedJson = nlohmann::ordered_json;
  OrderedJson ranges = OrderedJson::object();
  for (const auto& [layer, range] : file.ranges.of_layers)
    ranges[layer] = {range.least, range.most};
  const OrderedJson json{
      {"network", file.network.string()},    {"sha256", file.sha256},
      {"preprocessing", file.preprocessing}, {"checked", file.checked},
      {"input", file.ranges.input},          {"min_channels", file.ranges.min_channels},
      {"ranges", std::move(ranges)}};
  try {
    return json.dump(1) + "\n";
  } catch (const OrderedJson::type_error&) {
    return fail(
        "{}: its path, or a name in it, is no UTF-8: how it runs in 8 bits cannot be written",
        file.network.string());
  }
}

}  // namespace roomwise::network
