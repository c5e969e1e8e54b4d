#include "roomwise/network/vision/open_vocabulary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "roomwise/base/file.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/vision/classifier_outputs.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {
namespace {

Expected<Embedding> of_length_one(std::vector<float> values) {
  double squares = 0;
  for (const float value : values) squares += static_cast<double>(value) * value;
  if (!(squares > 0) || !std::isfinite(squares))
    return fail("the network gives no direction: its numbers are all 0, or not finite");
  for (float& value : values) value = static_cast<float>(value / std::sqrt(squares));
  return values;
}

// The one output that is asked for.
Expected<std::vector<float>> only_output(const Executor& executor, std::span<const Tensor> inputs) {
  ROOMWISE_TRY(std::vector<Tensor> outputs, executor.run(inputs));
  const Shape& shape = outputs.front().shape;
  if (outputs.size() != 1 || shape.size() != 2 || shape[0] != 1) {
    return fail("gives {} ({} in all); expected a single row of numbers", shape_text(shape),
                outputs.size());
  }
  return std::move(outputs.front().values);
}

// Of the task, with all sizes known: texts come one at a time, of as many places as the card says.
Expected<std::unique_ptr<Executor>> text_executor(const Bytes& bytes, const TextNetwork& text) {
  ROOMWISE_TRY(OnnxGraph graph, read_onnx_graph(bytes));
  ROOMWISE_RETURN_IF_ERROR(check_weights(graph));
  if (graph.inputs.size() > 2) {
    return fail("has {} inputs; expected the tokens, and at most which of them count",
                graph.inputs.size());
  }
  const Shape expected{1, text.places};
  const auto fits = [](std::int64_t given, std::int64_t wanted) {
    return given == GraphInput::kDynamic || given == wanted;
  };
  for (GraphInput& input : graph.inputs) {
    if (!std::ranges::equal(input.shape, expected, fits)) {
      return fail("its input \"{}\" has the shape {}; expected {} (batch x places)", input.name,
                  shape_text(input.shape), shape_text(expected));
    }
    input.shape = expected;
  }
  const bool is_there =
      text.tokens.empty() ||
      std::ranges::find(graph.inputs, text.tokens, &GraphInput::name) != graph.inputs.end();
  if (!is_there) return fail("has no input named \"{}\"", text.tokens);
  ExecutorOptions options;
  if (!text.output.empty()) options.outputs = {text.output};
  return Executor::create(std::move(graph), std::move(options));
}

// Of the parts, and of how a word is put to the network of texts.
std::string digest_of(std::vector<std::string> parts, const TextNetwork& text) {
  parts.push_back(fmt::format("{} {} {} {}", text.places, text.padding, text.tokens, text.output));
  parts.insert(parts.end(), text.phrases.begin(), text.phrases.end());
  std::string all;
  for (const std::string& part : parts) all += fmt::format("{}:{};", part.size(), part);
  return sha256_hex(Bytes(all.begin(), all.end()));
}

}  // namespace

double similarity(const Embedding& a, const Embedding& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

Expected<std::unique_ptr<OpenVocabulary>> OpenVocabulary::load(
    const std::filesystem::path& pictures) {
  const auto in = [](const std::filesystem::path& file) {
    return [&file](Error error) { return std::move(error).with_context(file.string()); };
  };
  ROOMWISE_TRY(NetworkFile file, read_network_in_floats(pictures));
  if (!file.card.text) {
    return fail(
        "{}: its card does not say that it compares pictures with words (\"task\": "
        "\"match-words\")",
        pictures.string());
  }
  const TextNetwork& text = *file.card.text;
  const std::filesystem::path folder = pictures.parent_path();
  const auto vocabulary =
      text.vocabulary.empty() ? std::optional<std::filesystem::path>() : folder / text.vocabulary;
  ROOMWISE_TRY(ClipTokenizer tokenizer, ClipTokenizer::read(folder / text.merges, vocabulary));
  std::unique_ptr<OpenVocabulary> both(new OpenVocabulary(file.card, std::move(tokenizer)));
  ROOMWISE_TRY(const ClassifierOutputs outputs, classifier_outputs(file).map_error(in(pictures)));
  ExecutorOptions options;
  options.outputs = outputs.features;
  ROOMWISE_TRY(both->pictures_,
               Executor::create(std::move(file.graph), std::move(options)).map_error(in(pictures)));
  const std::filesystem::path texts = folder / text.network;
  ROOMWISE_TRY(const Bytes bytes, read_file(texts));
  ROOMWISE_TRY(both->texts_, text_executor(bytes, text).map_error(in(texts)));
  std::vector<std::string> made_of{file.sha256, sha256_hex(bytes),
                                   preprocessing_of(file.card, outputs)};
  for (const auto& name : {text.merges, text.vocabulary}) {
    if (name.empty()) continue;
    ROOMWISE_TRY(const Bytes list, read_file(folder / name));
    made_of.push_back(sha256_hex(list));
  }
  both->fingerprint_ = digest_of(std::move(made_of), text);
  ROOMWISE_RETURN_IF_ERROR(both->probe().map_error(in(pictures)));
  return both;
}

Expected<void> OpenVocabulary::probe() {
  ROOMWISE_TRY(const Embedding picture,
               embed(image::ColorImage(card_.input_width_px, card_.input_height_px)));
  ROOMWISE_TRY(const Embedding word, embed("thing"));
  if (picture.size() != word.size()) {
    return fail("gives {} numbers, but {} gives {}: the two do not belong together", picture.size(),
                card_.text->network, word.size());
  }
  size_ = picture.size();
  return {};
}

Expected<Embedding> OpenVocabulary::embed(const image::ColorImage& picture) const {
  if (picture.empty()) return fail("the picture has no pixels");
  const Tensor input = picture_input(picture, card_);
  ROOMWISE_TRY(std::vector<float> values, only_output(*pictures_, {&input, 1}));
  return of_length_one(std::move(values));
}

Expected<Embedding> OpenVocabulary::embed(std::string_view word) const {
  std::vector<float> sum;
  for (const std::string& phrase : card_.text->phrases) {
    std::string text = phrase;
    text.replace(text.find("{}"), 2, word);
    ROOMWISE_TRY(const Embedding one, embed_text(text));
    sum.resize(one.size(), 0);
    std::ranges::transform(sum, one, sum.begin(), std::plus{});
  }
  return of_length_one(std::move(sum));
}

Expected<Embedding> OpenVocabulary::embed_text(std::string_view text) const {
  const TextNetwork& card = *card_.text;
  ROOMWISE_TRY(const auto tokens,
               tokenizer_.tokens(text, static_cast<std::size_t>(card.places), card.padding));
  const auto end = std::ranges::find(tokens, tokenizer_.end());
  std::vector<Tensor> inputs;
  for (const GraphInput& input : texts_->inputs()) {
    const bool takes_tokens = card.tokens.empty() ? inputs.empty() : input.name == card.tokens;
    Tensor& tensor = inputs.emplace_back(Tensor{input.shape, {}});
    for (auto token = tokens.begin(); token != tokens.end(); ++token) {
      // What else is asked for is which tokens count: those up to the end.
      tensor.values.push_back(takes_tokens ? static_cast<float>(*token) : token <= end ? 1.F : 0.F);
    }
  }
  return only_output(*texts_, inputs).and_then(of_length_one).map_error([&](Error error) {
    return std::move(error).with_context(card.network);
  });
}

}  // namespace roomwise::network
