#include "roomwise/objects/detection/activation_regions.h"

#include <gmock/gmock.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"

namespace roomwise::objects {
namespace {

using ::testing::HasSubstr;

// What cells of two words and something else say: "table lamp" and "lampshade" are lamps.
const std::vector<std::string> kCellLabels{"zebra", "table lamp", "lampshade, lamp shade",
                                           "bookcase"};

network::CellLogits cells_of(int columns, int rows) {
  network::CellLogits cells;
  cells.columns = columns;
  cells.rows = rows;
  cells.labels = kCellLabels.size();
  for (int cell = 0; cell < columns * rows; ++cell)
    cells.values.insert(cells.values.end(), {std::log(97.0F), 0, 0, 0});
  return cells;
}
// The probabilities of one cell, in the order of kCellLabels.
void say(network::CellLogits& cells, int column, int row, const std::vector<float>& said) {
  for (std::size_t label = 0; label < said.size(); ++label) {
    cells.values[static_cast<std::size_t>(row * cells.columns + column) * cells.labels + label] =
        std::log(said[label]);
  }
}

TEST(ActivationRegions, JoinsCellsThatShareASideAndLabelsOfOneWord) {
  auto cells = cells_of(4, 3);
  say(cells, 1, 0, {0.3F, 0.3F, 0.3F, 0.1F});  // a lamp by both labels together
  say(cells, 1, 1, {0.6F, 0.05F, 0.25F, 0.1F});
  say(cells, 2, 1, {0.2F, 0.15F, 0.1F, 0.55F});  // lamp enough to go along; and a bookcase
  say(cells, 3, 2, {0.1F, 0.45F, 0.4F, 0.05F});  // touches by a corner only
  const auto found =
      activation_regions(cells, kCellLabels, ObjectVocabulary::standard(), {0.5F, 0.2F}, 640, 480);
  ASSERT_EQ(found.size(), 3U);
  // Best first: the corner, the bookcase, the lamp of three cells.
  EXPECT_EQ(kCellLabels[found[0].label], "table lamp");
  EXPECT_NEAR(found[0].score, 0.85, 1e-5);
  EXPECT_EQ(found[0].box.left, 480);
  EXPECT_EQ(found[0].box.top, 320);
  EXPECT_EQ(found[0].box.right, 640);
  EXPECT_EQ(found[0].box.bottom, 480);
  EXPECT_EQ(kCellLabels[found[1].label], "bookcase");
  EXPECT_NEAR(found[1].score, 0.55, 1e-5);
  EXPECT_EQ(kCellLabels[found[2].label], "lampshade, lamp shade");
  EXPECT_EQ(found[2].box.left, 160);
  EXPECT_EQ(found[2].box.top, 0);
  EXPECT_EQ(found[2].box.right, 480);
  EXPECT_EQ(found[2].box.bottom, 320);
  // The mean of the logits is the geometric mean of the probabilities, made to sum to one.
  const auto geometric = [](double a, double b, double c) { return std::cbrt(a * b * c); };
  const double lamp = geometric(0.3, 0.05, 0.15) + geometric(0.3, 0.25, 0.1);
  EXPECT_NEAR(found[2].score, lamp / (lamp + geometric(0.3, 0.6, 0.2) + geometric(0.1, 0.1, 0.55)),
              1e-5);
}

TEST(ActivationRegions, LooksForTheGivenWordsAlone) {
  auto cells = cells_of(2, 2);
  say(cells, 0, 0, {0.1F, 0.8F, 0.05F, 0.05F});
  say(cells, 1, 1, {0.1F, 0.05F, 0.05F, 0.8F});
  ObjectVocabulary words;
  ASSERT_OK(words.add("bookcase", {"bookcase"}));
  const auto found = activation_regions(cells, kCellLabels, words, {}, 20, 20);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(kCellLabels[found[0].label], "bookcase");
  EXPECT_TRUE(activation_regions(cells_of(2, 2), kCellLabels, words, {}, 20, 20).empty());
}

class NamesOnly final : public DetectionFinder {
 public:
  explicit NamesOnly(std::vector<std::string> labels) : labels_(std::move(labels)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage&) const override {
    return std::vector<network::Detection>{};
  }

 private:
  std::string name_ = "names";
  std::vector<std::string> labels_;
};

TEST(WordsOfMaps, AreThoseThatMapsFindRightlyAndNoDetectorHas) {
  const std::vector<std::string> labels{"lampshade, lamp shade", "bookcase", "wardrobe", "zebra",
                                        "radiator"};
  DetectionFinders finders;
  finders.push_back(std::make_unique<NamesOnly>(std::vector<std::string>{"bed", "lampshade"}));
  const auto words = classes_of_maps(finders, labels, ObjectVocabulary::standard());
  EXPECT_EQ(words.objects().size(), 2U);
  EXPECT_TRUE(words.objects().contains("bookcase"))
      << "closer looks find lamps and wardrobes better";
  EXPECT_EQ(words.object_of("radiator"), "radiator") << "not in the table: a look-alike";
  finders.push_back(std::make_unique<NamesOnly>(std::vector<std::string>{"bookcase"}));
  const auto few = classes_of_maps(finders, labels, ObjectVocabulary::standard());
  EXPECT_FALSE(few.objects().contains("bookcase")) << "a detector has it";
  const auto alone = classes_of_maps({}, labels, ObjectVocabulary::standard());
  EXPECT_EQ(alone.objects().size(), 4U);
  for (const char* word : {"bookcase", "lamp", "wardrobe", "radiator"})
    EXPECT_TRUE(alone.objects().contains(word)) << word;
}

TEST(ActivationFinder, SaysHowItFindsInItsFingerprint) {
  const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  ObjectVocabulary lamps;
  ASSERT_OK(lamps.add("lamp", {"table lamp"}));
  const auto finder_of = [&](const ActivationOptions& options) {
    return activation_finder(network::DenseClassifier::load(*weights).value(), lamps, options);
  };
  const auto finder = finder_of({});
  EXPECT_EQ(finder->name(), "activation maps");
  EXPECT_THAT(finder->fingerprint(), HasSubstr("352x256"));
  EXPECT_EQ(source_of(finder->fingerprint()), DetectionSource::kActivation);
  EXPECT_EQ(source_of(finder->fingerprint().substr(0, 64)), DetectionSource::kDetector);
  EXPECT_NE(finder->fingerprint(), finder_of({0.6F, 0.2F})->fingerprint());
}

}  // namespace
}  // namespace roomwise::objects
