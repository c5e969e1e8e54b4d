#include "roomwise/network/vision/open_vocabulary.h"

#include <gmock/gmock.h>

#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/testing/word_networks.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

namespace fs = std::filesystem;
using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;

class OpenVocabularyTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_OK(write_word_networks(folder_.path())); }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, const std::string& text) const {
    ASSERT_OK(write_file(path(name), text));
  }
  void write(const std::string& name, const OnnxGraph& graph) const {
    ASSERT_OK(write_file(path(name), write_onnx_graph(graph).value()));
  }
  // The card with another text in the place of one.
  void change_card(const std::string& from, const std::string& to) const {
    std::string card = kWordCard;
    ASSERT_NE(card.find(from), card.npos);
    write("words.card.json", card.replace(card.find(from), from.size(), to));
  }

  roomwise::testing::ScratchFolder folder_;
};

TEST_F(OpenVocabularyTest, WordsFitThePicturesThatShowThem) {
  const auto both = OpenVocabulary::load(path("words.onnx"));
  ASSERT_OK(both);
  EXPECT_EQ((*both)->size(), 8U);
  const std::vector<std::string> colors{"red", "green", "blue"};
  const std::vector<Rgb8> shown{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto picture = (*both)->embed(image::ColorImage(20, 16, shown[i]));
    ASSERT_OK(picture);
    EXPECT_NEAR(similarity(*picture, *picture), 1, 1e-6);
    for (std::size_t j = 0; j < 3; ++j) {
      const auto word = (*both)->embed(colors[j]);
      ASSERT_OK(word);
      EXPECT_NEAR(similarity(*word, *word), 1, 1e-6);
      const double fits = similarity(*picture, *word);
      EXPECT_TRUE(i == j ? fits > 0.99 : fits < 0) << colors[j] << " " << fits;
    }
    EXPECT_LT(similarity(*picture, (*both)->embed("accordion").value()), 0.9);
  }
  EXPECT_ERROR((*both)->embed(image::ColorImage()), "no pixels");
}

// What is kept of pictures and words is then made anew.
TEST_F(OpenVocabularyTest, OtherFilesAndOtherWaysHaveOtherFingerprints) {
  const auto fingerprint = [&] {
    return OpenVocabulary::load(path("words.onnx")).value()->fingerprint();
  };
  std::set<std::string> seen{fingerprint()};
  EXPECT_TRUE(seen.contains(fingerprint()));
  change_card(R"(["{}"])", R"(["a {}"])");
  EXPECT_TRUE(seen.insert(fingerprint()).second);
  change_card("127.5", "127.0");
  EXPECT_TRUE(seen.insert(fingerprint()).second);
  write("words.card.json", std::string(kWordCard));
  write("words-merges.txt", std::string(kWordMerges) + "\n");
  EXPECT_TRUE(seen.insert(fingerprint()).second);
  OnnxGraph other = picture_network_of_words();
  other.nodes.front().name = "another";
  write("words.onnx", other);
  EXPECT_TRUE(seen.insert(fingerprint()).second);
  other = text_network_of_words();
  other.nodes.front().name = "another";
  write("words-text.onnx", other);
  EXPECT_TRUE(seen.insert(fingerprint()).second);
}

TEST_F(OpenVocabularyTest, PhrasesCountTogether) {
  change_card(R"(["{}"])", R"(["{}", "red {}"])");
  const auto both = OpenVocabulary::load(path("words.onnx"));
  ASSERT_OK(both);
  const auto embedded = (*both)->embed("green");
  ASSERT_OK(embedded);
  // Green alone, and red and green together: between the two, nearer to green.
  EXPECT_GT((*embedded)[1], (*embedded)[0]);
  EXPECT_GT((*embedded)[0], -0.5F);
}

// The mask of what counts ends behind the end of the text.
TEST_F(OpenVocabularyTest, TellsANetworkWhichTokensCount) {
  OnnxGraph graph = text_network_of_words();
  graph.inputs.push_back({"attention_mask", {1, kWordPlaces}, true});
  // The numbers of what counts, and of tokens that are not 0, which padding is here.
  graph.constants["zero"] = shared(numbers({}, {0}));
  graph.constants["fill"] = shared(numbers({1, 6}, {0, 0, 0, 0, 0, 0}));
  graph.nodes = {
      {"count", "Cast", "", {"attention_mask"}, {"ones"}, {{"to", Attribute(std::int64_t{1})}}},
      {"sum", "ReduceSum", "", {"ones"}, {"counted"}, {{"keepdims", Attribute(std::int64_t{1})}}},
      {"ids", "Cast", "", {"input_ids"}, {"all"}, {{"to", Attribute(std::int64_t{1})}}},
      {"least", "Greater", "", {"all", "zero"}, {"tokens"}, {}},
      {"as", "Cast", "", {"tokens"}, {"numbers"}, {{"to", Attribute(std::int64_t{1})}}},
      {"many", "ReduceSum", "", {"numbers"}, {"given"}, {{"keepdims", Attribute(std::int64_t{1})}}},
      {"both",
       "Concat",
       "",
       {"counted", "given", "fill"},
       {"embedding"},
       {{"axis", Attribute(std::int64_t{1})}}}};
  write("words-text.onnx", graph);
  const auto both = OpenVocabulary::load(path("words.onnx"));
  ASSERT_OK(both);
  const auto embedded = (*both)->embed("red blue");
  ASSERT_OK(embedded);
  EXPECT_GT((*embedded)[0], 0);
  EXPECT_EQ((*embedded)[0], (*embedded)[1]);
}

TEST_F(OpenVocabularyTest, SaysWhatIsMissingOrDoesNotFit) {
  const auto load = [&] { return OpenVocabulary::load(path("words.onnx")); };
  EXPECT_ERROR(OpenVocabulary::load(path("none.onnx")), "none.onnx");
  change_card("words-merges.txt", "other.txt");
  EXPECT_ERROR(load(), "other.txt: cannot be opened");
  change_card("words-text.onnx", "other.onnx");
  EXPECT_ERROR(load(), "other.onnx");
  change_card(R"("places": 16)", R"("tokens": "ids")");
  EXPECT_ERROR(load(), "words-text.onnx: has no input named \"ids\"");
  change_card(R"("places": 16)", R"("output": "other")");
  EXPECT_ERROR(load(), "no output or node named \"other\"");
  write("words.card.json", std::string(kWordCard));
  OnnxGraph narrow = text_network_of_words();
  narrow.inputs.front().shape = {1, 5};
  write("words-text.onnx", narrow);
  EXPECT_ERROR(load(), "has the shape 1x5; expected 1x16");
  OnnxGraph other = picture_network_of_words();
  other.constants["weights"] = shared(numbers({3, 2}, {1, 1, 1, 1, 1, 1}));
  write("words.onnx", other);
  write("words-text.onnx", text_network_of_words());
  EXPECT_ERROR(load(), "gives 2 numbers, but words-text.onnx gives 8");
  // More pieces than the network of texts has rows.
  write("words.onnx", picture_network_of_words());
  write("words-merges.txt", std::string(kWordMerges) + "a b\nc d\n");
  EXPECT_ERROR(load(), "there is no index");
}

TEST_F(OpenVocabularyTest, IsNoNetworkThatLooksAtPicturesAlone) {
  EXPECT_ERROR(OnnxClassifier::load(path("words.onnx")), "compares pictures with words");
  write("words.card.json", std::string(R"({"input": {"width": 8, "height": 8}})"));
  EXPECT_ERROR(OpenVocabulary::load(path("words.onnx")), "\"task\": \"match-words\"");
}

}  // namespace
}  // namespace roomwise::network
