#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/graph/graph_builder.h"
#include "roomwise/network/vision/classifier_quantization.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

using image::ColorImage;
using roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;

constexpr int kWidth_px = 20, kHeight_px = 18;

ColorImage noise(std::uint64_t seed) {
  RandomStream random(seed);
  ColorImage picture(kWidth_px, kHeight_px);
  for (Rgb8& pixel : picture.pixels()) {
    const auto bits = static_cast<std::uint32_t>(random.next());
    pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16)};
  }
  return picture;
}

class EightBits : public ::testing::Test {
 protected:
  EightBits() {
    GraphBuilder builder({5, false});
    auto x = builder.input("picture", {1, 3, kHeight_px, kWidth_px});
    x = builder.relu(builder.convolution(x, "first", {16, {3, 3}, {2, 2}, {1, 1}}), "first.relu");
    x = builder.relu(builder.convolution(x, "second", {24, {3, 3}, {1, 1}, {1, 1}}), "second.relu");
    x = builder.relu(builder.convolution(x, "third", {40}), "third.relu");
    builder.output(builder.flatten(builder.global_average_pool(x, "pool"), "features"));
    write("tiny.card.json", fmt::format(R"({{"input": {{"width": {}, "height": {}}},
        "mean": [127.5, 127.5, 127.5], "scale": [0.008, 0.008, 0.008]}})",
                                        kWidth_px, kHeight_px));
    EXPECT_OK(write_file(weights(), *write_onnx_graph(builder.take())));
  }

  [[nodiscard]] std::filesystem::path weights() const { return folder_ / "tiny.onnx"; }
  void write(const std::string& name, std::string_view text) {
    EXPECT_OK(write_file(folder_ / name, text));
  }
  // tiny-8bit.eightbits, of which `change` may make something else.
  std::filesystem::path quantized(const std::function<void(EightBitFile&)>& change = {}) {
    auto result = quantize_classifier(weights(), 80, noise);
    EXPECT_OK(result);
    EXPECT_TRUE(result->report.is_used) << result->report.reason;
    EXPECT_EQ(result->measured_on, 20u);
    EXPECT_EQ(result->checked_on, 60u);
    result->file.network = "tiny.onnx";
    if (change) change(result->file);
    write("tiny-8bit.eightbits", *text_of(result->file));
    return folder_ / "tiny-8bit.eightbits";
  }

  ScratchFolder folder_;
};

TEST_F(EightBits, AreANetworkOfTheirOwnThatSeesNearlyTheSame) {
  const auto exact = OnnxClassifier::load(weights()), rounded = OnnxClassifier::load(quantized());
  ASSERT_OK(exact);
  ASSERT_OK(rounded);
  EXPECT_EQ((*rounded)->name(), "tiny (8 bits)");
  EXPECT_NE((*rounded)->fingerprint(), (*exact)->fingerprint());
  EXPECT_EQ((*rounded)->preprocessing(), (*exact)->preprocessing());
  const auto expected = (*exact)->predict(noise(99))->features,
             features = (*rounded)->predict(noise(99))->features;
  ASSERT_EQ(features.size(), expected.size());
  EXPECT_NE(features, expected) << "nothing is in 8 bits";
  double product = 0, of_a = 0, of_b = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    product += static_cast<double>(features[i]) * expected[i];
    of_a += static_cast<double>(features[i]) * features[i];
    of_b += static_cast<double>(expected[i]) * expected[i];
  }
  EXPECT_GT(product / std::sqrt(of_a * of_b), 0.998);
}

TEST_F(EightBits, AreTheSameAfterTheyWereRead) {
  const auto path = quantized();
  const auto file = read_eight_bit_file(path);
  ASSERT_OK(file);
  EXPECT_EQ(*text_of(*file), *read_text_file(path));
  EXPECT_THAT(file->checked, HasSubstr("measured on 20 pictures, checked on 60 others"));
}

TEST_F(EightBits, AreOfOneFileOfWeights) {
  const auto of_another = quantized([](EightBitFile& file) { file.sha256[0] ^= 1; });
  EXPECT_ERROR(OnnxClassifier::load(of_another), "was measured of another file");
  const auto of_none = quantized([](EightBitFile& file) { file.network = "gone.onnx"; });
  EXPECT_ERROR(OnnxClassifier::load(of_none), "gone.onnx, which is not there");
  const auto of_a_folder = quantized([](EightBitFile& file) { file.network = "folder.onnx"; });
  std::filesystem::create_directory(folder_ / "folder.onnx");
  EXPECT_ERROR(OnnxClassifier::load(of_a_folder), "folder.onnx, which is not there");
  const auto of_itself =
      quantized([](EightBitFile& file) { file.network = "tiny-8bit.eightbits"; });
  EXPECT_ERROR(OnnxClassifier::load(of_itself),
               "network: expected the file of a network's weights");
  EXPECT_ERROR(find_model_card(of_itself), "network: expected");
}

TEST_F(EightBits, AreOfOneCard) {
  const auto path = quantized();
  write("tiny.card.json",
        fmt::format(R"({{"input": {{"width": {}, "height": {}}}}})", kWidth_px, kHeight_px));
  EXPECT_ERROR(OnnxClassifier::load(path), "was measured with another card");
}

// Homes remember it.
TEST_F(EightBits, AreTheSameNetworkWhereverTheyLie) {
  const auto fingerprint = [&](const std::function<void(EightBitFile&)>& change) {
    const auto network = OnnxClassifier::load(quantized(change));
    EXPECT_OK(network);
    return (*network)->fingerprint();
  };
  const std::string plain = fingerprint({});
  EXPECT_EQ(fingerprint([](EightBitFile& file) { file.checked = "by somebody else"; }), plain);
  EXPECT_EQ(fingerprint([](EightBitFile& file) { file.network = "./tiny.onnx"; }), plain);
  EXPECT_NE(fingerprint([](EightBitFile& file) { file.ranges.min_channels = 17; }), plain);
  EXPECT_NE(fingerprint([](EightBitFile& file) { file.ranges.of_layers["third"].most *= 2; }),
            plain);
}

// One convolution, that looks at the picture.
TEST_F(EightBits, AreNotUsedWhereNothingIsGained) {
  GraphBuilder builder({5, false});
  auto x = builder.input("picture", {1, 3, kHeight_px, kWidth_px});
  x = builder.relu(builder.convolution(x, "only", {16, {3, 3}}), "only.relu");
  builder.output(builder.flatten(builder.global_average_pool(x, "pool"), "features"));
  ASSERT_OK(write_file(weights(), *write_onnx_graph(builder.take())));
  const auto result = quantize_classifier(weights(), 80, noise);
  ASSERT_OK(result);
  EXPECT_FALSE(result->report.is_used);
  EXPECT_THAT(result->report.reason, HasSubstr("nothing in it can be held in 8 bits"));
}

// A Roomwise that joins layers otherwise.
TEST_F(EightBits, WithALayerThatNobodyMeasuredAreRefused) {
  const auto path = quantized([](EightBitFile& file) { file.ranges.of_layers.erase("second"); });
  EXPECT_ERROR(OnnxClassifier::load(path), "nothing was measured of the layer \"second\"");
}

TEST_F(EightBits, AreForWholePicturesOnly) {
  const auto path = quantized();
  EXPECT_ERROR(read_network_in_floats(path), "give the network's own file here");
  EXPECT_ERROR(Detector::load(path), "give the network's own file here");
  EXPECT_ERROR(quantize_classifier(path, 80, noise), "give the network's own file here");
}

TEST_F(EightBits, NeedEnoughPicturesThatCanBeRead) {
  EXPECT_ERROR(quantize_classifier(weights(), 79, noise), "at least 80 pictures");
  const auto broken = [](std::size_t i) -> Expected<ColorImage> {
    if (i == 5) return fail("the sixth is broken");
    return noise(i);
  };
  EXPECT_ERROR(quantize_classifier(weights(), 80, broken), "the sixth is broken");
}

TEST_F(EightBits, OfManyPicturesTakeSomeFromAllOver) {
  std::vector<std::size_t> taken;
  const auto result = quantize_classifier(weights(), 1000, [&](std::size_t i) {
    taken.push_back(i);
    return noise(i);
  });
  ASSERT_OK(result);
  EXPECT_EQ(taken.size(), 320u);
  EXPECT_EQ(taken.front(), 0u);
  EXPECT_GT(taken.back(), 990u);
  EXPECT_EQ(result->measured_on, 80u);
}

TEST(EightBitFile, NamesAreUtf8) {
  EightBitFile file;
  file.network = "bad\xff.onnx";
  EXPECT_ERROR(text_of(file), "no UTF-8");
}

TEST(EightBitFile, NamesTheFieldThatIsWrong) {
  const auto parse = [](const std::string& changed, const std::string& value) {
    nlohmann::json json = {
        {"network", "n.onnx"},   {"sha256", "0"},     {"preprocessing", ""},      {"checked", ""},
        {"input", {1, 3, 5, 5}}, {"min_channels", 1}, {"ranges", {{"a", {0, 1}}}}};
    json[changed] = nlohmann::json::parse(value);
    return parse_eight_bit_file(json.dump(), "n.eightbits");
  };
  EXPECT_OK(parse("min_channels", "65"));
  EXPECT_ERROR(parse_eight_bit_file("", "n.eightbits"), "n.eightbits: is not JSON");
  EXPECT_ERROR(parse_eight_bit_file("{}", "n.eightbits"), "n.eightbits: network");
  EXPECT_ERROR(parse("network", "\"\""), "network: expected the file");
  EXPECT_ERROR(parse("sha256", "5"), "sha256: expected a text");
  EXPECT_ERROR(parse("input", "[1, 3, 5]"), "input: expected four");
  EXPECT_ERROR(parse("input", "[1, 3, 5, 99999]"), "input: expected four");
  EXPECT_ERROR(parse("input", "[1, 3, 5, 0.5]"), "input: expected four");
  EXPECT_ERROR(parse("min_channels", "0"), "min_channels");
  EXPECT_ERROR(parse("ranges", "5"), "ranges: expected");
  EXPECT_ERROR(parse("ranges", R"({"a": [0]})"), "n.eightbits: ranges: layer \"a\"");
  EXPECT_ERROR(parse("ranges", R"({"a": [2, 1]})"), "2 to 1 is no range");
  EXPECT_ERROR(parse("ranges", R"({"a": [0, 1e300]})"), "is no range");
  EXPECT_ERROR(parse("network", "\"/dev/zero\""), "network: expected the file");
  EXPECT_ERROR(parse("steps", "1"), "steps: unknown field");
}

}  // namespace
}  // namespace roomwise::network
