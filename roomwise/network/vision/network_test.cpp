#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <numeric>
#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

using image::ColorImage;
using roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using roomwise::testing::field;
using roomwise::testing::mean_color_network;
using roomwise::testing::node;
using roomwise::testing::onnx;
using roomwise::testing::tensor_info;

class OnnxClassifierTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, std::string_view text) {
    const std::filesystem::path path = folder_ / name;
    EXPECT_TRUE(write_file(path, text).has_value());
    return path;
  }
  // tiny.onnx with its card; `more` are further fields of the card, beginning with a comma.
  std::filesystem::path write_tiny(const std::string& more = "",
                                   const std::string& network = mean_color_network(),
                                   const std::string& input_more = "") {
    write("tiny.card.json",
          R"({"input": {"width": 6, "height": 4)" + input_more + "}" + more + "}");
    return write("tiny.onnx", network);
  }

  ScratchFolder folder_;
};

TEST_F(OnnxClassifierTest, PutsThePictureInAsTheCardSays) {
  const auto weights = write_tiny(R"(, "mean": [10, 20, 30], "scale": [1, 0.5, 2])");
  const auto network = OnnxClassifier::load(weights);
  ASSERT_OK(network);
  EXPECT_EQ((*network)->name(), "tiny");
  EXPECT_EQ((*network)->feature_size(), 3u);
  EXPECT_TRUE((*network)->labels().empty());
  const auto prediction = (*network)->predict(ColorImage(12, 8, Rgb8{110, 120, 130}));
  ASSERT_OK(prediction);
  EXPECT_THAT(prediction->features, ElementsAre(100, 50, 200));
  EXPECT_TRUE(prediction->scores.empty());
}

TEST_F(OnnxClassifierTest, TellsWaysToPutPicturesInApart) {
  const auto preprocessing = [&](const std::string& more, const std::string& input_more = "") {
    const auto network =
        OnnxClassifier::load(write_tiny(more, mean_color_network(), input_more)).value();
    return network->preprocessing();
  };
  const std::string plain = preprocessing("");
  EXPECT_EQ(preprocessing(R"(, "name": "other", "license": "MIT", "mean": [0, 0, 0])"), plain);
  std::set<std::string> ways{plain};
  ways.insert(preprocessing(R"(, "mean": [0, 0, 1])"));
  ways.insert(preprocessing(R"(, "mean": [0, 0, 1.0000001])"));
  ways.insert(preprocessing(R"(, "scale": [1, 1, 0.5])"));
  ways.insert(preprocessing("", R"(, "colors": "bgr")"));
  ways.insert(preprocessing("", R"(, "fit": "crop")"));
  EXPECT_THAT(ways, ::testing::SizeIs(6));
}

TEST_F(OnnxClassifierTest, PutsColorsInTheOrderOfTheCard) {
  const auto network =
      OnnxClassifier::load(write_tiny("", mean_color_network(), R"(, "colors": "bgr")"));
  ASSERT_OK(network);
  const auto prediction = (*network)->predict(ColorImage(6, 4, Rgb8{1, 2, 3}));
  ASSERT_OK(prediction);
  EXPECT_THAT(prediction->features, ElementsAre(3, 2, 1));
}

TEST_F(OnnxClassifierTest, FitsThePictureAsTheCardSays) {
  // Red where a centre crop to 6:4 of a 36x4 picture looks, black beside it.
  ColorImage wide(36, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 15; x < 21; ++x) wide.at(x, y) = {240, 0, 0};
  }
  const auto stretched = OnnxClassifier::load(write_tiny());
  ASSERT_OK(stretched);
  EXPECT_FLOAT_EQ((*stretched)->predict(wide)->features[0], 40);
  const auto cropped =
      OnnxClassifier::load(write_tiny("", mean_color_network(), R"(, "fit": "crop")"));
  ASSERT_OK(cropped);
  EXPECT_FLOAT_EQ((*cropped)->predict(wide)->features[0], 240);
}

TEST_F(OnnxClassifierTest, GivesScoresWhereThereAreLabels) {
  const auto weights = write_tiny(R"(, "labels": "colors.txt", "outputs": {"softmax": true})");
  write("colors.txt", "red\r\ngreen\r\nblue");
  const auto network = OnnxClassifier::load(weights);
  ASSERT_OK(network);
  EXPECT_THAT((*network)->labels(), ElementsAre("red", "green", "blue"));
  const auto prediction = (*network)->predict(ColorImage(6, 4, Rgb8{1, 2, 2}));
  ASSERT_OK(prediction);
  const auto& scores = prediction->scores;
  ASSERT_EQ(scores.size(), 3u);
  EXPECT_NEAR(scores[0] + scores[1] + scores[2], 1, 1e-6);
  EXPECT_NEAR(scores[1] / scores[0], std::exp(1.0), 1e-5);
  EXPECT_EQ(prediction->features, scores) << "the only output serves as features too";
}

TEST_F(OnnxClassifierTest, RefusesWeightsThatAreNotFinite) {
  const auto path =
      write_tiny("", onnx(roomwise::testing::TinyGraph{
                         {roomwise::testing::layer("Add", {"picture", "shift"}, {"sum"}),
                          node("GlobalAveragePool", "sum", "means")},
                         {roomwise::testing::tensor("shift", {1}, std::vector<float>{NAN})},
                         {1, 3, 4, 6},
                         {{"means", {1, 3, 1, 1}}}}));
  EXPECT_ERROR(OnnxClassifier::load(path), path.string() + ": its tensor \"shift\" holds 1 of 1");
}

TEST_F(OnnxClassifierTest, ReadsFeaturesFromAnInnerLayer) {
  const std::string network =
      onnx({node("GlobalAveragePool", "picture", "pooled"), node("Flatten", "pooled", "means"),
            node("Softmax", "means", "scores")},
           {1, 3, 4, 6}, {{"scores", {1, 3}}});
  write("colors.txt", "red\ngreen\nblue\n");
  const auto loaded = OnnxClassifier::load(write_tiny(
      R"(, "labels": "colors.txt", "outputs": {"features": "pooled_node", "scores": "scores"})",
      network));
  ASSERT_OK(loaded);
  const auto prediction = (*loaded)->predict(ColorImage(6, 4, Rgb8{7, 8, 9}));
  ASSERT_OK(prediction);
  EXPECT_THAT(prediction->features, ElementsAre(7, 8, 9));
  EXPECT_NEAR(std::accumulate(prediction->scores.begin(), prediction->scores.end(), 0.0), 1, 1e-6);
}

TEST_F(OnnxClassifierTest, JoinsSeveralOutputsSoThatEachCountsTheSame) {
  // A feature map, averaged over the picture, and its averages: the same values twice.
  const std::string network =
      onnx({node("Relu", "picture", "map"), node("GlobalAveragePool", "map", "pooled"),
            node("Flatten", "pooled", "means")},
           {1, 3, 4, 6}, {{"means", {1, 3}}});
  const auto loaded = OnnxClassifier::load(
      write_tiny(R"(, "outputs": {"features": ["map_node", "means"]})", network));
  ASSERT_OK(loaded);
  const auto prediction = (*loaded)->predict(ColorImage(6, 4, Rgb8{20, 0, 15}));
  ASSERT_OK(prediction);
  EXPECT_THAT(prediction->features,
              ::testing::Pointwise(::testing::FloatEq(), {0.8F, 0.F, 0.6F, 0.8F, 0.F, 0.6F}));
}

// What was seen by another card is not what it would see now.
TEST_F(OnnxClassifierTest, FingerprintIsOfTheWeightsAndOfWhatACardOfOnesOwnDecides) {
  std::set<std::string> seen;
  const auto is_new = [&](const std::string& more, const std::string& input_more = "") {
    const auto network = OnnxClassifier::load(write_tiny(more, mean_color_network(), input_more));
    EXPECT_OK(network);
    return seen.insert((*network)->fingerprint()).second;
  };
  write("three.txt", "red\ngreen\nblue\n");
  EXPECT_TRUE(is_new(""));
  EXPECT_FALSE(is_new(R"(, "license": "MIT", "notes": ["seen"], "mean": [0, 0, 0.0])"));
  EXPECT_TRUE(is_new(R"(, "mean": [0, 0, 1])"));
  EXPECT_TRUE(is_new(R"(, "scale": [1, 1, 2])"));
  EXPECT_TRUE(is_new("", R"(, "colors": "bgr")"));
  EXPECT_TRUE(is_new(R"(, "outputs": {"features": "pooled_node"})"));
  EXPECT_TRUE(is_new(R"(, "labels": "three.txt")"));
  EXPECT_TRUE(is_new(R"(, "labels": "three.txt", "outputs": {"softmax": true})"));
  write("three.txt", "red\ngreen\npurple\n");
  EXPECT_TRUE(is_new(R"(, "labels": "three.txt")"));
}

TEST_F(OnnxClassifierTest, FingerprintIsTheHashOfTheWeightsWithoutACardOfOnesOwn) {
  const std::string name = "roomwise-compact-2";
  const auto copy = [&](const std::string& file) {
    const auto text = read_text_file(std::filesystem::path(ROOMWISE_MODELS_FOLDER) / file);
    EXPECT_OK(text);
    return write(file, *text);
  };
  copy(name + ".labels.txt");
  const auto weights = copy(name + ".onnx");
  const auto bytes = read_file(weights);
  ASSERT_OK(bytes);
  const auto fingerprint = [&] { return read_network_in_floats(weights).value().fingerprint; };
  EXPECT_EQ(fingerprint(), sha256_hex(*bytes));
  copy(name + ".card.json");
  EXPECT_EQ(fingerprint(), sha256_hex(*bytes)) << "it says the same";
}

TEST_F(OnnxClassifierTest, ACardsDigestMayBeInCapitalsAndIsWhole) {
  const auto bytes = read_file(write_tiny());
  ASSERT_OK(bytes);
  std::string digest = sha256_hex(*bytes);
  std::ranges::transform(digest, digest.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  EXPECT_OK(OnnxClassifier::load(write_tiny(R"(, "sha256": ")" + digest + "\"")));
  digest.pop_back();
  EXPECT_ERROR(OnnxClassifier::load(write_tiny(R"(, "sha256": ")" + digest + "\"")),
               "sha256: expected 64 hexadecimal digits");
}

TEST_F(OnnxClassifierTest, RefusesAPictureWithoutPixels) {
  const auto network = OnnxClassifier::load(write_tiny());
  ASSERT_OK(network);
  EXPECT_ERROR((*network)->predict(ColorImage()), "no pixels");
}

TEST_F(OnnxClassifierTest, NamesAMissingFile) {
  EXPECT_ERROR(OnnxClassifier::load(folder_ / "none.onnx"), "none.onnx");
}

TEST_F(OnnxClassifierTest, SaysWhatToWriteWhereTheCardIsMissing) {
  const auto weights = write("stranger.onnx", mean_color_network());
  EXPECT_ERROR(OnnxClassifier::load(weights), "write stranger.card.json beside it");
}

TEST_F(OnnxClassifierTest, RefusesWhatIsNoOnnxNetwork) {
  const auto garbage = write_tiny("", "this is no network");
  EXPECT_ERROR(OnnxClassifier::load(garbage), "tiny.onnx: is no ONNX network");
  const auto empty = write_tiny("", "");
  EXPECT_ERROR(OnnxClassifier::load(empty), "tiny.onnx: is no ONNX network");
}

TEST_F(OnnxClassifierTest, RefusesATruncatedNetwork) {
  const std::string whole = mean_color_network();
  for (const std::size_t kept : {whole.size() - 1, whole.size() / 2, std::size_t{3}}) {
    EXPECT_FALSE(OnnxClassifier::load(write_tiny("", whole.substr(0, kept))).has_value()) << kept;
  }
}

TEST_F(OnnxClassifierTest, RefusesANetworkThatTakesNoPictures) {
  const std::string takes_rows = onnx({node("Relu", "picture", "out")}, {1, 7}, {{"out", {1, 7}}});
  EXPECT_ERROR(OnnxClassifier::load(write_tiny("", takes_rows)),
               "input \"picture\" has the shape 1x7; expected 1x3x4x6");
}

TEST_F(OnnxClassifierTest, RefusesAnotherInputSizeThanTheCards) {
  write("tiny.card.json", R"({"input": {"width": 9, "height": 9}})");
  const auto weights = write("tiny.onnx", mean_color_network());
  EXPECT_ERROR(OnnxClassifier::load(weights), "has the shape 1x3x4x6; expected 1x3x9x9");
}

TEST_F(OnnxClassifierTest, RefusesANetworkOfTwoInputs) {
  std::string network = mean_color_network();
  const std::string second = field(7, field(11, tensor_info("more", {1, 3, 4, 6})));
  EXPECT_ERROR(OnnxClassifier::load(write_tiny("", network + second)), "has 2 inputs");
}

TEST_F(OnnxClassifierTest, TakesASizeThatTheFileLeavesOpen) {
  const std::string open_batch =
      onnx({node("GlobalAveragePool", "picture", "pooled"), node("Flatten", "pooled", "means")},
           {0, 3, 4, 6}, {{"means", {1, 3}}});
  EXPECT_OK(OnnxClassifier::load(write_tiny("", open_batch)));
}

TEST_F(OnnxClassifierTest, NamesBothNumbersWhereLabelsDoNotFit) {
  write("two.txt", "red\ngreen\n");
  EXPECT_ERROR(OnnxClassifier::load(write_tiny(), folder_ / "two.txt"),
               "gives 3 scores, but there are 2 labels");
}

TEST_F(OnnxClassifierTest, NamesMissingAndEmptyLabels) {
  EXPECT_ERROR(OnnxClassifier::load(write_tiny(), folder_ / "none.txt"), "none.txt");
  EXPECT_ERROR(OnnxClassifier::load(write_tiny(R"(, "labels": "gone.txt")")), "gone.txt");
  EXPECT_ERROR(read_labels(write("empty.txt", "")), "holds no label");
  EXPECT_ERROR(read_labels(write("gap.txt", "red\n\nblue\n")), "gap.txt:2");
}

TEST_F(OnnxClassifierTest, NamesOutputsThatAreNotThereOrNotChosen) {
  EXPECT_ERROR(OnnxClassifier::load(write_tiny(R"(, "outputs": {"features": "pool5"})")),
               "no output or node named \"pool5\"");
  const std::string two = onnx({node("GlobalAveragePool", "picture", "pooled"),
                                node("Flatten", "pooled", "means"), node("Relu", "pooled", "warm")},
                               {1, 3, 4, 6}, {{"means", {1, 3}}, {"warm", {1, 3, 1, 1}}});
  EXPECT_ERROR(OnnxClassifier::load(write_tiny("", two)), "2 outputs");
}

TEST(ModelCard, IsReadWhole) {
  const auto card = ModelCard::parse(
      R"({"name": "n", "input": {"width": 8, "height": 9, "colors": "bgr", "fit": "crop"},
          "mean": [1, 2, 3], "scale": [4, 5, 6], "labels": "l.txt", "license": "MIT", "source": "s",
          "first_label": 1, "architecture": "inception-v3",
          "outputs": {"features": ["f", "g"], "scores": "p", "softmax": true}})",
      "here");
  ASSERT_OK(card);
  EXPECT_EQ(card->name, "n");
  EXPECT_EQ(card->input_width_px, 8);
  EXPECT_EQ(card->input_height_px, 9);
  EXPECT_EQ(card->color_order, ColorOrder::kBgr);
  EXPECT_EQ(card->fit, PictureFit::kCenterCrop);
  EXPECT_THAT(card->mean, ElementsAre(1, 2, 3));
  EXPECT_THAT(card->scale, ElementsAre(4, 5, 6));
  EXPECT_THAT(card->features_outputs, ElementsAre("f", "g"));
  EXPECT_EQ(card->scores_output, "p");
  EXPECT_TRUE(card->scores_need_softmax);
  EXPECT_EQ(card->labels_file, "l.txt");
  EXPECT_EQ(card->first_label, 1);
  EXPECT_EQ(card->architecture, Architecture::kInceptionV3);
  EXPECT_EQ(card->license, "MIT");
  EXPECT_EQ(card->source, "s");
}

TEST(ModelCard, NamesTheFieldThatIsWrong) {
  const auto parse = [](const char* json) { return ModelCard::parse(json, "c.card.json"); };
  EXPECT_ERROR(parse("{"), "c.card.json: is not JSON");
  EXPECT_ERROR(parse("[]"), "c.card.json: is not JSON");
  EXPECT_ERROR(parse("{}"), "c.card.json: input.width");
  EXPECT_ERROR(parse(R"({"input": 5})"), "c.card.json: input");
  EXPECT_ERROR(parse(R"({"input": {"width": 5}})"), "input.height");
  EXPECT_ERROR(parse(R"({"input": {"width": 0, "height": 5}})"), "input.width");
  EXPECT_ERROR(parse(R"({"input": {"width": 5.5, "height": 5}})"), "input.width");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 99999999999}})"), "input.height");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5, "colors": "hsv"}})"), "input.colors");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "mean": [1, 2]})"), "mean");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "scale": "big"})"), "scale");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "scales": [1, 1, 1]})"),
               "scales: unknown field");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "outputs": {"softmax": 1}})"),
               "outputs.softmax");
  EXPECT_ERROR(parse(R"({"task": "dream", "input": {"width": 5, "height": 5}})"),
               "task: expected \"classify\" or \"nanodet-plus\" or \"yolox\" or \"yolov5\" or "
               "\"yolov8\" or \"match-words\", not \"dream\"");
  EXPECT_ERROR(parse(R"({"task": "nanodet-plus",
                         "input": {"width": 5, "height": 5, "fit": "crop"}})"),
               "input.fit");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "first_label": -1})"), "first_label");
  EXPECT_ERROR(parse(R"({"input": {"width": 5, "height": 5}, "architecture": "vgg"})"),
               "architecture: expected \"own\" or \"inception-v3\", not \"vgg\"");
}

TEST(ModelCard, OfWordsNamesTheNetworkOfTexts) {
  const auto parse = [](const std::string& more) {
    return ModelCard::parse(R"({"input": {"width": 5, "height": 5})" + more + "}", "c.card.json");
  };
  const auto card = parse(R"(, "task": "match-words", "text": {"network": "t.onnx", "merges": "m",
      "vocabulary": "v.json", "tokens": "ids", "output": "e", "places": 16, "padding": 3,
      "phrases": ["{}", "a {}"]})");
  ASSERT_OK(card);
  EXPECT_EQ(card->task, Task::kMatchWords);
  EXPECT_FALSE(finds_things(card->task));
  ASSERT_TRUE(card->text.has_value());
  EXPECT_EQ(card->text->network, "t.onnx");
  EXPECT_EQ(card->text->merges, "m");
  EXPECT_EQ(card->text->vocabulary, "v.json");
  EXPECT_EQ(card->text->tokens, "ids");
  EXPECT_EQ(card->text->output, "e");
  EXPECT_EQ(card->text->places, 16);
  EXPECT_EQ(card->text->padding, 3);
  EXPECT_THAT(card->text->phrases, ElementsAre("{}", "a {}"));
  EXPECT_ERROR(parse(R"(, "task": "match-words")"), "text: expected { ... }");
  EXPECT_ERROR(parse(R"(, "text": {"network": "t.onnx", "merges": "m"})"), "and only there");
  const auto parse_text = [&](const std::string& text) {
    return parse(R"(, "task": "match-words", "text": )" + text);
  };
  EXPECT_ERROR(parse_text(R"({"merges": "m"})"), "text.network");
  EXPECT_ERROR(parse_text(R"({"network": "t"})"), "text.merges");
  EXPECT_ERROR(parse_text(R"({"network": "t", "merges": "m", "places": 1})"), "text.places");
  EXPECT_ERROR(parse_text(R"({"network": "t", "merges": "m", "phrases": ["a"]})"), "text.phrases");
  EXPECT_ERROR(parse_text(R"({"network": "t", "merges": "m", "size": 1})"), "text.size");
}

// Those whose addresses the catalogue has are found by their published files' names.
TEST(ModelCard, OfPublishedDetectorsAreBroughtAlong) {
  for (const char* name :
       {"yolox_nano", "yolox_tiny", "yolox_s", "yolox_m", "nanodet-plus-m_416"}) {
    const auto card = find_model_card(std::string("nowhere/") + name + ".onnx");
    ASSERT_OK(card);
    EXPECT_TRUE(finds_things(card->task)) << name;
    EXPECT_EQ(card->labels_file, "coco-labels-80.txt") << name;
  }
}

// That of torchvision's weights, which a user puts beside the labels of 1001 classes.
TEST(ModelCard, OfTorchvisionsInceptionIsBroughtAlong) {
  const auto card = find_model_card("nowhere/inception_v3_google-0cc3c7bd.pth");
  ASSERT_OK(card);
  EXPECT_EQ(card->architecture, Architecture::kInceptionV3);
  EXPECT_EQ(card->first_label, 1);
}

TEST(ModelCard, BesideTheWeightsWinsOverTheBuiltIn) {
  const ScratchFolder folder;
  const auto weights = folder / "mobilenet-v2-imagenet.onnx";
  const auto built_in = find_model_card(weights);
  ASSERT_OK(built_in);
  EXPECT_EQ(built_in->input_width_px, 224);
  EXPECT_EQ(built_in->labels_file, "imagenet-labels-1001.txt");
  ASSERT_OK(write_file(folder / "mobilenet-v2-imagenet.card.json",
                       R"({"input": {"width": 96, "height": 96}})"));
  const auto beside = find_model_card(weights);
  ASSERT_OK(beside);
  EXPECT_EQ(beside->input_width_px, 96);
}

// The real networks.

ColorImage read_object_photo(const std::filesystem::path& folder, const std::string& file) {
  auto photo = image::read_color(folder / file);
  EXPECT_TRUE(photo.has_value()) << photo.error().message;
  return photo.value_or(ColorImage(1, 1));
}

TEST(RealNetworks, MobileNetNamesHouseholdObjects) {
  const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  const auto photos = roomwise::testing::find_data("object_photos");
  ROOMWISE_REQUIRE_FILE(photos);
  const auto network = OnnxClassifier::load(*weights);
  ASSERT_OK(network);
  EXPECT_EQ((*network)->labels().size(), 1001u);
  EXPECT_EQ((*network)->feature_size(), 1280u);
  const auto best_label = [&](const std::string& file) {
    const auto prediction = (*network)->predict(read_object_photo(*photos, file));
    EXPECT_TRUE(prediction.has_value());
    const auto& scores = prediction->scores;
    EXPECT_NEAR(std::accumulate(scores.begin(), scores.end(), 0.0), 1, 1e-3);
    return (*network)->labels()[static_cast<std::size_t>(
        std::max_element(scores.begin(), scores.end()) - scores.begin())];
  };
  EXPECT_EQ(best_label("n04447861_toilet_seat.jpg"), "toilet seat");
  EXPECT_EQ(best_label("n04380533_table_lamp.jpg"), "table lamp");
  EXPECT_EQ(best_label("n02504458_African_elephant.jpg"), "African elephant, Loxodonta africana");
}

TEST(RealNetworks, SameBitsFromSeveralThreads) {
  const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  const auto photos = roomwise::testing::find_data("object_photos");
  ROOMWISE_REQUIRE_FILE(photos);
  const auto network = OnnxClassifier::load(*weights);
  ASSERT_OK(network);
  const ColorImage photo = read_object_photo(*photos, "n04330267_stove.jpg");
  const auto alone = (*network)->predict(photo);
  ASSERT_OK(alone);
  ThreadPool pool(4);
  std::vector<std::future<Expected<Prediction>>> together;
  for (int i = 0; i < 8; ++i) {
    together.push_back(pool.submit([&] { return (*network)->predict(photo); }));
  }
  for (auto& future : together) {
    const auto prediction = future.get();
    ASSERT_OK(prediction);
    EXPECT_EQ(prediction->features, alone->features);
    EXPECT_EQ(prediction->scores, alone->scores);
  }
}

TEST(RealNetworks, InceptionTrunkServesFeaturesOnly) {
  const auto weights = roomwise::testing::find_model("inception-2015-12-05-trunk.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  const auto network = OnnxClassifier::load(*weights);
  ASSERT_OK(network);
  EXPECT_EQ((*network)->feature_size(), 768u + 2560u);
  EXPECT_TRUE((*network)->labels().empty());
}

}  // namespace
}  // namespace roomwise::network
