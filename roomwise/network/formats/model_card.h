#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// How a picture of any shape is brought to the network's input size.
enum class PictureFit {
  kStretch,     // width and height scaled apart
  kCenterCrop,  // the largest centred part of the input's proportions
  kPad,         // scaled as a whole into the input's upper left corner, the rest grey (114)
};
enum class ColorOrder { kRgb, kBgr };
// What a network is for.
enum class Task {
  kClassify,  // looks at whole pictures: features, and scores of labels (OnnxClassifier)
  // Finds things in a picture (Detector), giving boxes as the network of this name does.
  kNanoDetPlus,
  kYolox,
  kYolov5,
  kYolov8,
  kMatchWords,  // compares pictures with words (OpenVocabulary), beside a network of texts
};
[[nodiscard]] bool finds_things(Task task);
// "classify", "nanodet-plus", "yolox", "yolov5", "yolov8" or "match-words".
[[nodiscard]] std::string_view name_of(Task task);

// Which network the weights are of.
enum class Architecture {
  kOwn,          // that of the ONNX file that holds them
  kInceptionV3,  // torchvision's (inception_v3.h); its outputs are "features" and "fc"
};

// The network that tells what texts mean, beside one that looks at pictures (Task::kMatchWords).
struct TextNetwork {
  std::string network;     // its ONNX file, beside the pictures'
  std::string merges;      // the list of pairs of its tokenizer (clip_tokenizer.h), beside both
  std::string vocabulary;  // the numbers of its pieces, likewise; empty: OpenAI's
  std::string tokens;      // the input that takes these; empty: the first
  std::string output;      // empty: its only one
  int places = 77;         // tokens a text
  int padding = 0;         // the token behind a text's end
  // Sentences that a word is put into, at "{}"; a word means what they mean together.
  std::vector<std::string> phrases{"a photo of a {}."};
};

// What a weights file does not say about itself: how a picture is put in, and what comes out. A
// value of the input is (x - mean) * scale, x the 8-bit colour value.
//
// Written as JSON; everything but "input" may be left out:
//   { "name": "my-network", "task": "classify",
//     "input": { "width": 224, "height": 224, "colors": "rgb", "fit": "stretch" },
//     "mean": [127.5, 127.5, 127.5], "scale": [0.0078, 0.0078, 0.0078],
//     "outputs": { "features": "pool5", "scores": "prob", "softmax": false },
//     "labels": "labels.txt", "first_label": 0,
//     "license": "Apache-2.0", "source": "where it came from",
//     "sha256": "the weights file's, 64 digits", "notes": ["what else is known of it"] }
// "features" may be a list of names; "task" may be "nanodet-plus", "yolox", "yolov5" or "yolov8";
// "fit" may be "crop" or, where things are found, "pad".
// A network of the task "match-words" has one of texts beside it:
//   "text": { "network": "text.onnx", "merges": "bpe_simple_vocab_16e6.txt.gz",
//             "vocabulary": "vocab.json", "tokens": "input_ids", "output": "text_embeds",
//             "places": 77, "padding": 0, "phrases": ["a photo of a {}."] }
// of which "network" and "merges" must be there.
// Weights without their network (.pth, .safetensors) are of an "architecture": "inception-v3".
struct ModelCard {
  std::string name;  // the weights file's name without its ending where the card gives none
  Task task = Task::kClassify;
  int input_width_px = 0;
  int input_height_px = 0;
  ColorOrder color_order = ColorOrder::kRgb;
  PictureFit fit = PictureFit::kStretch;
  std::array<float, 3> mean{0, 0, 0};  // in the order of color_order
  std::array<float, 3> scale{1, 1, 1};
  // Names of ONNX outputs or nodes. Where both are empty, the network's only output gives the
  // scores if there are labels and the features if there are none; where only the features' are
  // empty, the scores serve as features too. Feature maps are averaged over the picture; several
  // outputs are each scaled to length 1, so that they count the same, and joined.
  std::vector<std::string> features_outputs;
  std::string scores_output;
  bool scores_need_softmax = false;  // the scores are not yet probabilities
  std::string labels_file;           // beside the weights; empty: the network names nothing
  int first_label = 0;  // of the labels' file: those before it are of classes that it does not know
  Architecture architecture = Architecture::kOwn;
  std::string license;
  std::string source;
  std::string sha256;               // of the weights file; empty: any file is taken
  std::optional<TextNetwork> text;  // of kMatchWords alone
  std::vector<std::string> notes;   // for people: how it was trained, how well it does
  // Where it lies beside the weights, and Roomwise brings along none of that name that says the
  // same: what it says that decides what the network sees. Else empty.
  std::string own;

  // Fails, naming `origin` (the card's file) and the field, on anything missing, unknown or out of
  // range.
  [[nodiscard]] static Expected<ModelCard> parse(std::string_view json, const std::string& origin);
};

// The card of a network: NAME.card.json beside NAME.onnx (or .pth, .safetensors), else the card of
// this name that Roomwise brings along (models/*.card.json). In 8 bits (NAME.eightbits), that of
// the network. Fails where there is neither, saying what to write and where.
[[nodiscard]] Expected<ModelCard> find_model_card(const std::filesystem::path& weights);

}  // namespace roomwise::network
