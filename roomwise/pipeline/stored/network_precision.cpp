#include "roomwise/pipeline/stored/network_precision.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/network/formats/built_in_cards.h"
#include "roomwise/network/vision/classifier_outputs.h"
#include "roomwise/pipeline/stored/network_precision_key.h"

namespace roomwise::pipeline {
namespace {

using Json = nlohmann::ordered_json;
using network::EightBitFile;
using network::NetworkFile;

constexpr std::array<std::pair<std::string_view, NetworkPrecision>, 3> kPrecisions{
    {{"auto", NetworkPrecision::kAuto},
     {"float", NetworkPrecision::kFloat},
     {"eight-bits", NetworkPrecision::kEightBits}}};

constexpr std::string_view kSetting = "precision of network ";

std::string setting_of(const std::string& fingerprint) {
  return std::string(kSetting) + fingerprint;
}

bool may_be_in_eight_bits(const NetworkFile& file) {
  return file.card.task == network::Task::kClassify && file.labels.empty() && !file.eight_bits;
}

Expected<std::string> preprocessing_now(const NetworkFile& file) {
  ROOMWISE_TRY(const auto outputs, network::classifier_outputs(file));
  return network::preprocessing_of(file.card, outputs);
}

Expected<std::string> text_of(const PrecisionCheck& check, const EightBitFile& how) {
  Json json{{"preprocessing", how.preprocessing}, {"why", check.why}};
  if (check.eight_bits) {
    EightBitFile stored = *check.eight_bits;
    stored.network = stored.network.filename();  // its folder is another elsewhere
    ROOMWISE_TRY(json["eight_bits"], network::text_of(stored));
  }
  return json.dump();
}

struct StoredCheck {
  std::string preprocessing;  // of the card that the network had
  PrecisionCheck check;
};

Expected<StoredCheck> parse_check(const std::string& text, const std::string& origin) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto has_text = [&](const char* key) {
    return json.is_object() && json.contains(key) && json.at(key).is_string();
  };
  if (!has_text("preprocessing") || !has_text("why"))
    return fail("{}: is damaged; put back a copy of it", origin);
  StoredCheck stored{json.at("preprocessing"), {std::nullopt, json.at("why")}};
  if (has_text("eight_bits")) {
    ROOMWISE_TRY(stored.check.eight_bits,
                 network::parse_eight_bit_file(json.at("eight_bits").get<std::string>(), origin));
  }
  return stored;
}

Expected<bool> were_rooms_learned_with(const home::Home& home, const std::string& fingerprint) {
  ROOMWISE_TRY(const auto learned, home.room_classifier());
  return learned && learned->network_fingerprint == fingerprint;
}

Expected<bool> is_known_in_floats(const home::Home& home, const std::string& fingerprint) {
  ROOMWISE_TRY(const auto networks, home.networks());
  const bool has_looked = std::ranges::any_of(
      networks, [&](const auto& entry) { return entry.second.fingerprint == fingerprint; });
  if (has_looked) return true;
  return were_rooms_learned_with(home, fingerprint);
}

}  // namespace

Expected<NetworkPrecision> parse_network_precision(std::string_view name) {
  const auto* found =
      std::ranges::find(kPrecisions, name, &decltype(kPrecisions)::value_type::first);
  if (found == kPrecisions.end())
    return fail("\"{}\" is no precision of networks; expected auto, float or eight-bits", name);
  return found->second;
}

Expected<std::optional<PrecisionCheck>> stored_precision_check(const home::Home& home,
                                                               const NetworkFile& file) {
  std::optional<PrecisionCheck> check;
  if (!may_be_in_eight_bits(file)) return check;
  ROOMWISE_TRY(const auto settings, home.settings());
  const auto stored = settings.find(setting_of(file.sha256));
  if (stored == settings.end()) return check;
  ROOMWISE_TRY(const std::string now, preprocessing_now(file));
  ROOMWISE_TRY(StoredCheck read, parse_check(stored->second, home.file() + ": " + stored->first));
  if (read.preprocessing == now) check = std::move(read.check);
  return check;
}

Expected<std::vector<EightBitFile>> stored_ways_of_eight_bits(const home::Home& home) {
  ROOMWISE_TRY(const auto settings, home.settings());
  std::vector<EightBitFile> ways;
  for (const auto& [name, value] : settings) {
    if (!name.starts_with(kSetting)) continue;
    ROOMWISE_TRY(StoredCheck read, parse_check(value, home.file() + ": " + name));
    if (read.check.eight_bits) ways.push_back(*std::move(read.check.eight_bits));
  }
  return ways;
}

Expected<std::string> network_precision_key(const home::Home& home) {
  ROOMWISE_TRY(const auto settings, home.settings());
  ROOMWISE_TRY(const auto learned, home.room_classifier());
  std::string key = learned ? learned->network_fingerprint : "";
  for (const auto& [name, value] : settings) {
    if (name.starts_with(kSetting)) key += "\n" + name + "\n" + value;
  }
  return key;
}

Expected<bool> needs_precision_check(const home::Home& home, const NetworkFile& file,
                                     NetworkPrecision precision) {
  if (precision == NetworkPrecision::kFloat || !may_be_in_eight_bits(file)) return false;
  ROOMWISE_TRY(const auto stored, stored_precision_check(home, file));
  if (stored) return false;
  if (precision == NetworkPrecision::kEightBits) return true;
  ROOMWISE_TRY(const bool is_known, is_known_in_floats(home, file.fingerprint));
  return !is_known;
}

Expected<PrecisionCheck> check_precision(home::Home& home, const std::filesystem::path& weights,
                                         std::size_t pictures, const network::PictureAt& picture,
                                         std::size_t threads, const network::RunsDone& runs_done) {
  constexpr std::size_t kTaken = network::kMinQuantizationPictures;
  if (pictures < kTaken) {
    return PrecisionCheck{
        std::nullopt, fmt::format("8 bits need {} pictures of the home to be checked on, not {}",
                                  kTaken, pictures)};
  }
  ROOMWISE_TRY(auto quantized,
               network::quantize_classifier(
                   weights, kTaken, [&](std::size_t i) { return picture(i * pictures / kTaken); },
                   threads, runs_done));
  PrecisionCheck check{.eight_bits = std::nullopt, .why = quantized.report.reason};
  if (quantized.report.is_used) check = {quantized.file, quantized.file.checked};
  ROOMWISE_TRY(const std::string text, text_of(check, quantized.file));
  ROOMWISE_RETURN_IF_ERROR(home.put_setting(setting_of(quantized.file.sha256), text));
  return check;
}

Expected<NetworkFile> in_precision(const home::Home& home, NetworkFile file,
                                   NetworkPrecision precision) {
  if (precision == NetworkPrecision::kFloat || !may_be_in_eight_bits(file)) return file;
  ROOMWISE_TRY(auto check, stored_precision_check(home, file));
  if (precision == NetworkPrecision::kEightBits && (!check || !check->eight_bits)) {
    return fail("{}: the network {} cannot look at it in 8 bits: {}", home.file(), file.card.name,
                check
                    ? check->why
                    : "that was not checked yet; map, objects find and rooms learn --photos do so "
                      "with --network-precision eight-bits, on 80 pictures or more");
  }
  if (!check || !check->eight_bits) return file;
  if (precision == NetworkPrecision::kAuto) {
    ROOMWISE_TRY(const bool are_in_floats, were_rooms_learned_with(home, file.fingerprint));
    if (are_in_floats) return file;
  }
  return network::in_eight_bits(std::move(file), *std::move(check->eight_bits));
}

Expected<NetworkFile> known_as_before(const home::Home& home, NetworkFile file,
                                      const std::filesystem::path& weights) {
  const bool is_brought = network::find_built_in_card(weights.stem().string()) != nullptr;
  if (file.card.own.empty() || file.eight_bits || is_brought) return file;
  ROOMWISE_TRY(const bool is_known, is_known_in_floats(home, file.fingerprint));
  if (is_known) return file;
  ROOMWISE_TRY(const bool was_known, is_known_in_floats(home, file.sha256));
  if (was_known) file.fingerprint = file.sha256;
  return file;
}

}  // namespace roomwise::pipeline
