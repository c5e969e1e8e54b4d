#include "roomwise/network/formats/model_card.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/built_in_cards.h"
#include "roomwise/network/formats/eight_bit_file.h"

namespace roomwise::network {
namespace {

const std::initializer_list<std::pair<std::string_view, Task>> kTasks{
    {"classify", Task::kClassify}, {"nanodet-plus", Task::kNanoDetPlus},
    {"yolox", Task::kYolox},       {"yolov5", Task::kYolov5},
    {"yolov8", Task::kYolov8},     {"match-words", Task::kMatchWords}};

using Json = nlohmann::json;

// Reads the fields of one JSON object, naming it in every error ("NAME.card.json: input.width").
class Fields {
 public:
  Fields(const Json& object, std::string where) : object_(object), where_(std::move(where)) {}

  [[nodiscard]] Expected<void> expect_only(std::initializer_list<std::string_view> known) const {
    for (const auto& [key, value] : object_.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        return fail("{}{}: unknown field; known are {}", where_, key, fmt::join(known, ", "));
      }
    }
    return {};
  }

  [[nodiscard]] Expected<std::string> text(const char* key, const std::string& otherwise) const {
    return value(key, otherwise, &Json::is_string, "a text in quotes");
  }
  [[nodiscard]] Expected<bool> flag(const char* key, bool otherwise) const {
    return value(key, otherwise, &Json::is_boolean, "true or false");
  }
  [[nodiscard]] Expected<int> whole(const char* key, int least, int most, int otherwise) const {
    const auto is_right = [&](const Json& number) { return is_whole(number, least, most); };
    return value(key, otherwise, is_right,
                 fmt::format("a whole number from {} to {}", least, most));
  }
  // The number of a line, from 0; 0 where it is absent.
  [[nodiscard]] Expected<int> line(const char* key) const {
    const auto is_line = [](const Json& line) { return is_whole(line, 0, 1 << 20); };
    return value(key, 0, is_line, "the number of a line, from 0");
  }
  [[nodiscard]] Expected<int> side_px(const char* key) const {
    constexpr int kMaxSide_px = 4096;
    const auto is_side = [](const Json& side) { return is_whole(side, 1, kMaxSide_px); };
    const std::string expected =
        fmt::format("the input's side, a whole number of pixels from 1 to {}", kMaxSide_px);
    if (!object_.contains(key)) return fail("{}{}: expected {}", where_, key, expected);
    return value(key, 0, is_side, expected);
  }

  // One text, or a list of them.
  [[nodiscard]] Expected<std::vector<std::string>> texts(const char* key) const {
    std::vector<std::string> texts;
    if (!object_.contains(key)) return texts;
    const Json& value = object_.at(key);
    for (const Json& element : value.is_array() ? value : Json::array({value})) {
      if (!element.is_string()) return fail("{}{}: expected texts in quotes", where_, key);
      texts.push_back(element.get<std::string>());
    }
    return texts;
  }

  [[nodiscard]] Expected<std::array<float, 3>> per_channel(const char* key,
                                                           std::array<float, 3> otherwise) const {
    if (!object_.contains(key)) return otherwise;
    const Json& values = object_.at(key);
    std::array<float, 3> channels{};
    bool valid = values.is_array() && values.size() == channels.size();
    for (std::size_t i = 0; valid && i < channels.size(); ++i) {
      valid = values[i].is_number();
      if (valid) channels[i] = values[i].get<float>();
      valid = valid && std::isfinite(channels[i]);
    }
    if (!valid) return fail("{}{}: expected three numbers, one a colour channel", where_, key);
    return channels;
  }

  // A nested object; an empty one where it is absent.
  [[nodiscard]] Expected<Json> object(const char* key) const {
    if (!object_.contains(key)) return Json::object();
    if (!object_.at(key).is_object()) return fail("{}{}: expected {{ ... }}", where_, key);
    return object_.at(key);
  }

  // One of a few words; the first where it is absent.
  template <typename Value>
  [[nodiscard]] Expected<Value> choice(
      const char* key, std::initializer_list<std::pair<std::string_view, Value>> choices) const {
    ROOMWISE_TRY(const std::string word, text(key, std::string(choices.begin()->first)));
    std::string known;
    for (const auto& [name, value] : choices) {
      if (word == name) return value;
      known += fmt::format("{}\"{}\"", known.empty() ? "" : " or ", name);
    }
    return fail("{}{}: expected {}, not \"{}\"", where_, key, known, word);
  }

 private:
  static bool is_whole(const Json& value, int least, int most) {
    return value.is_number_integer() && value >= least && value <= most;
  }
  // The field, which must be as `is_right` says; `otherwise` where it is absent.
  template <typename T, typename Check>
  [[nodiscard]] Expected<T> value(const char* key, T otherwise, const Check& is_right,
                                  std::string_view expected) const {
    if (!object_.contains(key)) return otherwise;
    const Json& value = object_.at(key);
    if (!std::invoke(is_right, value)) return fail("{}{}: expected {}", where_, key, expected);
    return value.get<T>();
  }

  const Json& object_;
  std::string where_;
};

Expected<TextNetwork> parse_text_network(const Json& object, const std::string& origin) {
  const Fields fields(object, origin + ": text.");
  ROOMWISE_RETURN_IF_ERROR(fields.expect_only(
      {"network", "merges", "vocabulary", "tokens", "output", "places", "padding", "phrases"}));
  TextNetwork text;
  ROOMWISE_TRY(text.network, fields.text("network", ""));
  ROOMWISE_TRY(text.merges, fields.text("merges", ""));
  if (text.network.empty()) return fail("{}: text.network: expected an ONNX file", origin);
  if (text.merges.empty()) return fail("{}: text.merges: expected a list of pairs", origin);
  ROOMWISE_TRY(text.vocabulary, fields.text("vocabulary", ""));
  ROOMWISE_TRY(text.tokens, fields.text("tokens", ""));
  ROOMWISE_TRY(text.output, fields.text("output", ""));
  constexpr int kMaxPlaces = 4096, kMaxToken = 1 << 24;
  ROOMWISE_TRY(text.places, fields.whole("places", 2, kMaxPlaces, text.places));
  ROOMWISE_TRY(text.padding, fields.whole("padding", 0, kMaxToken, text.padding));
  if (object.contains("phrases")) {
    ROOMWISE_TRY(text.phrases, fields.texts("phrases"));
    const auto has_place = [](const std::string& phrase) {
      return phrase.find("{}") != phrase.npos;
    };
    if (text.phrases.empty() || !std::ranges::all_of(text.phrases, has_place))
      return fail("{}: text.phrases: expected sentences with {{}} where the word stands", origin);
  }
  return text;
}

// All that decides what a network sees, but for its texts (OpenVocabulary::fingerprint()).
std::string decisive_text(const ModelCard& card) {
  const Json all{name_of(card.task),
                 card.input_width_px,
                 card.input_height_px,
                 card.color_order,
                 card.fit,
                 card.mean,
                 card.scale,
                 card.features_outputs,
                 card.scores_output,
                 card.scores_need_softmax,
                 card.labels_file,
                 card.first_label,
                 card.architecture};
  return all.dump();
}

std::optional<Expected<ModelCard>> brought_card(const std::string& name) {
  const BuiltInText* const found = find_built_in_card(name);
  if (found == nullptr) return std::nullopt;
  return ModelCard::parse(found->text, fmt::format("models/{}.card.json", name));
}

bool is_sha256_hex(std::string_view text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == text.npos;
}

}  // namespace

bool finds_things(Task task) {
  return task != Task::kClassify && task != Task::kMatchWords;
}

std::string_view name_of(Task task) {
  return std::ranges::find(kTasks, task, [](const auto& one) { return one.second; })->first;
}

Expected<ModelCard> ModelCard::parse(std::string_view json, const std::string& origin) {
  const Json root = Json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (!root.is_object()) {
    return fail("{}: is not JSON; expected a model card, {{ \"input\": {{ ... }}, ... }}", origin);
  }
  const Fields card(root, origin + ": ");
  ROOMWISE_RETURN_IF_ERROR(card.expect_only({"name", "task", "input", "mean", "scale", "outputs",
                                             "labels", "first_label", "architecture", "license",
                                             "source", "sha256", "text", "notes"}));
  ROOMWISE_TRY(const Json input_object, card.object("input"));
  ROOMWISE_TRY(const Json outputs_object, card.object("outputs"));
  const Fields input(input_object, origin + ": input.");
  const Fields outputs(outputs_object, origin + ": outputs.");
  ROOMWISE_RETURN_IF_ERROR(input.expect_only({"width", "height", "colors", "fit"}));
  ROOMWISE_RETURN_IF_ERROR(outputs.expect_only({"features", "scores", "softmax"}));

  ModelCard result;
  ROOMWISE_TRY(result.name, card.text("name", ""));
  ROOMWISE_TRY(result.task, card.choice<Task>("task", kTasks));
  ROOMWISE_TRY(result.input_width_px, input.side_px("width"));
  ROOMWISE_TRY(result.input_height_px, input.side_px("height"));
  ROOMWISE_TRY(result.color_order, input.choice<ColorOrder>("colors", {{"rgb", ColorOrder::kRgb},
                                                                       {"bgr", ColorOrder::kBgr}}));
  ROOMWISE_TRY(result.fit, input.choice<PictureFit>("fit", {{"stretch", PictureFit::kStretch},
                                                            {"crop", PictureFit::kCenterCrop},
                                                            {"pad", PictureFit::kPad}}));
  ROOMWISE_TRY(result.mean, card.per_channel("mean", result.mean));
  ROOMWISE_TRY(result.scale, card.per_channel("scale", result.scale));
  if (finds_things(result.task) && result.fit == PictureFit::kCenterCrop) {
    return fail(
        "{}: input.fit: a network that finds things takes the whole picture: \"stretch\" or "
        "\"pad\"",
        origin);
  }
  ROOMWISE_TRY(result.features_outputs, outputs.texts("features"));
  ROOMWISE_TRY(result.scores_output, outputs.text("scores", ""));
  ROOMWISE_TRY(result.scores_need_softmax, outputs.flag("softmax", false));
  ROOMWISE_TRY(result.labels_file, card.text("labels", ""));
  ROOMWISE_TRY(result.first_label, card.line("first_label"));
  ROOMWISE_TRY(
      result.architecture,
      card.choice<Architecture>("architecture", {{"own", Architecture::kOwn},
                                                 {"inception-v3", Architecture::kInceptionV3}}));
  ROOMWISE_TRY(result.license, card.text("license", ""));
  ROOMWISE_TRY(result.source, card.text("source", ""));
  ROOMWISE_TRY(result.sha256, card.text("sha256", ""));
  std::ranges::transform(result.sha256, result.sha256.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!result.sha256.empty() && !is_sha256_hex(result.sha256)) {
    return fail("{}: sha256: expected 64 hexadecimal digits", origin);
  }
  ROOMWISE_TRY(result.notes, card.texts("notes"));
  const bool matches_words = result.task == Task::kMatchWords;
  if (matches_words != root.contains("text")) {
    return fail("{}: text: expected {{ ... }} where the task is \"match-words\", and only there",
                origin);
  }
  if (matches_words) {
    ROOMWISE_TRY(const Json text, card.object("text"));
    ROOMWISE_TRY(result.text, parse_text_network(text, origin));
  }
  return result;
}

Expected<ModelCard> find_model_card(const std::filesystem::path& weights) {
  if (is_eight_bit_file(weights)) {
    ROOMWISE_TRY(const EightBitFile how, read_eight_bit_file(weights));
    ROOMWISE_TRY(ModelCard card, find_model_card(weights.parent_path() / how.network));
    card.name = name_in_eight_bits(card.name);
    return card;
  }
  const std::string name = weights.stem().string();
  const auto with_name = [&](ModelCard card) {
    if (card.name.empty()) card.name = name;
    return card;
  };
  auto brought = brought_card(name);
  const std::filesystem::path beside = weights.parent_path() / (name + ".card.json");
  std::error_code ignored;
  if (std::filesystem::exists(beside, ignored)) {
    ROOMWISE_TRY(const std::string json, read_text_file(beside));
    ROOMWISE_TRY(ModelCard card, ModelCard::parse(json, beside.string()));
    std::string text = decisive_text(card);
    if (!brought || !*brought || decisive_text(**brought) != text) card.own = std::move(text);
    return with_name(std::move(card));
  }
  if (brought) return (*std::move(brought)).map(with_name);
  return fail(
      "{}: nothing says what this network takes; write {} beside it, for example {{ \"input\": {{ "
      "\"width\": 224, \"height\": 224, \"colors\": \"rgb\" }}, \"mean\": [127.5, 127.5, 127.5], "
      "\"scale\": [0.0078, 0.0078, 0.0078] }}",
      weights.string(), beside.filename().string());
}

}  // namespace roomwise::network
