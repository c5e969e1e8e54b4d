#include "roomwise/objects/detection/crop_regions.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::objects {
namespace {

using network::PixelBox;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Says of a picture what its middle pixel's red channel stands for.
class SaysByRed final : public network::Classifier {
 public:
  std::map<int, std::vector<float>> scores_by_red;

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] std::size_t feature_size() const override { return 0; }
  [[nodiscard]] Expected<network::Prediction> predict(
      const image::ColorImage& image) const override {
    EXPECT_EQ(image.width(), image.height());
    sizes_px.push_back(image.width());
    const auto said = scores_by_red.find(image.at(image.width() / 2, image.height() / 2).r);
    if (said == scores_by_red.end()) return fail("nothing is known of this red");
    return network::Prediction{{}, said->second};
  }
  mutable std::vector<int> sizes_px;

 private:
  std::string name_ = "by red";
  std::vector<std::string> labels_{"table lamp", "lampshade", "washer", "zebra"};
};

constexpr int kLampRed = 10, kWasherRed = 20, kZebraRed = 30;

struct Scene {
  image::ColorImage picture{200, 100};
  SaysByRed classifier;
  std::vector<network::Detection> boxes;

  Scene() {
    classifier.scores_by_red = {{0, {0, 0, 0, 1}},
                                {kLampRed, {0.3F, 0.4F, 0.2F, 0.1F}},
                                {kWasherRed, {0.1F, 0.1F, 0.8F, 0}},
                                {kZebraRed, {0.2F, 0.2F, 0.1F, 0.5F}}};
  }
  void show(const PixelBox& box, int red, float score = 0.3F) {
    for (int y = static_cast<int>(box.top); y < static_cast<int>(box.bottom); ++y) {
      for (int x = static_cast<int>(box.left); x < static_cast<int>(box.right); ++x)
        picture.at(x, y).r = static_cast<std::uint8_t>(red);
    }
    boxes.push_back({75, score, box});
  }
  [[nodiscard]] std::vector<network::Detection> found(const ObjectVocabulary& words) const {
    auto regions = crop_regions(picture, boxes, classifier, words, {});
    EXPECT_OK(regions);
    return regions.value_or(std::vector<network::Detection>{});
  }
};

const ObjectVocabulary& standard() {
  static const ObjectVocabulary vocabulary = ObjectVocabulary::standard();
  return vocabulary;
}

bool is_same(const PixelBox& a, const PixelBox& b) {
  return network::intersection_over_union(a, b) == 1;
}

TEST(SquareAbout, LiesInThePictureAboutTheBox) {
  EXPECT_TRUE(is_same(square_about({90, 40, 110, 50}, 1, 200, 100), {90, 35, 110, 55}));
  EXPECT_TRUE(is_same(square_about({90, 40, 110, 50}, 2, 200, 100), {80, 25, 120, 65}));
  EXPECT_TRUE(is_same(square_about({0, 0, 20, 10}, 1.5F, 200, 100), {0, 0, 30, 30}))
      << "moved into the picture";
  EXPECT_TRUE(is_same(square_about({50, 20, 190, 90}, 1, 200, 100), {70, 0, 170, 100}))
      << "no larger than the picture";
}

TEST(CropRegions, AreNamedByWhatTheCropSaysAndNotByTheDetector) {
  Scene scene;
  const PixelBox lamp{20, 20, 40, 60}, washer{100, 10, 150, 90};
  scene.show(lamp, kLampRed);
  scene.show(washer, kWasherRed, 0.2F);
  const auto found = scene.found(standard());
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(scene.classifier.labels()[found[0].label], "washer") << "the surest first";
  EXPECT_FLOAT_EQ(found[0].score, 0.8F);
  EXPECT_TRUE(is_same(found[0].box, washer));
  EXPECT_EQ(scene.classifier.labels()[found[1].label], "lampshade") << "its word's likeliest";
  EXPECT_FLOAT_EQ(found[1].score, 0.7F) << "both labels of the word";
  EXPECT_TRUE(is_same(found[1].box, lamp));
  EXPECT_EQ(scene.classifier.sizes_px, (std::vector<int>{46, 92})) << "1.15 of the longest side";
}

TEST(CropRegions, AreOfTheGivenWordsAndSaidEnough) {
  Scene scene;
  scene.show({20, 20, 40, 60}, kZebraRed);
  EXPECT_THAT(scene.found(standard()), IsEmpty()) << "0.4 for a lamp, a zebra is no word";
  scene.show({100, 10, 150, 90}, kWasherRed);
  EXPECT_THAT(scene.found(standard()), SizeIs(1));
  ObjectVocabulary lamps;
  ASSERT_OK(lamps.add("lamp", {"table lamp", "lampshade"}));
  EXPECT_THAT(scene.found(lamps), IsEmpty());
}

TEST(CropRegions, LookOnceAtABoxOfTwoNames) {
  Scene scene;
  scene.show({20, 20, 40, 60}, kLampRed, 0.4F);
  scene.show({20, 20, 41, 61}, kLampRed, 0.3F);
  EXPECT_THAT(scene.found(standard()), SizeIs(1));
  EXPECT_THAT(scene.classifier.sizes_px, SizeIs(1));
}

TEST(CropRegions, OfWhatStandsBesideAThingAreLeftOut) {
  Scene scene;
  const PixelBox lamp{60, 30, 80, 50}, nightstand{50, 42, 90, 80};
  scene.classifier.scores_by_red[40] = {0.3F, 0.25F, 0, 0.45F};
  scene.show(nightstand, 40);  // its crop shows the lamp, too, and says so
  scene.show(lamp, kLampRed);
  const auto found = scene.found(standard());
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_TRUE(is_same(found[0].box, lamp));
  scene.show({150, 42, 190, 80}, 40);
  EXPECT_THAT(scene.found(standard()), SizeIs(2)) << "a third one stands alone";
}

TEST(CropRegions, AreNoneOfWhatHoldsNothingOrIsNoNumber) {
  Scene scene;
  scene.classifier.scores_by_red[40] = {std::nanf(""), std::nanf(""), 0.2F, 0};
  scene.show({100, 10, 150, 90}, 40);
  scene.boxes.push_back({75, 0.9F, {30, 30, 30, 60}});
  EXPECT_THAT(scene.found(standard()), IsEmpty());
  scene.show({20, 20, 40, 60}, kLampRed);
  EXPECT_THAT(scene.found(standard()), SizeIs(1));
  EXPECT_ERROR(crop_regions({}, scene.boxes, scene.classifier, standard(), {}), "without pixels");
}

TEST(CropRegions, SayWhereTheClassifierFails) {
  Scene scene;
  scene.show({20, 20, 40, 60}, 77);
  const auto found = crop_regions(scene.picture, scene.boxes, scene.classifier, standard(), {});
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("this red"));
}

TEST(WordsOfCrops, AreThoseThatCropsFindRightlyAndLookAlikes) {
  const auto words = classes_of_crops({"table lamp", "studio couch, day bed", "radiator", "zebra"},
                                      ObjectVocabulary::standard());
  EXPECT_EQ(words.objects().size(), 2U);
  EXPECT_TRUE(words.objects().contains("lamp"));
  EXPECT_TRUE(words.objects().contains("radiator"));
}

TEST(CropFinder, FindsALampThatTheDetectorHasNoWordFor) {
  const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
  const auto boxes = roomwise::testing::find_model("nanodet-plus-m-416.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  ROOMWISE_REQUIRE_FILE(boxes);
  const std::shared_ptr<const network::Detector> detector = network::Detector::load(*boxes).value();
  const auto finder_of = [&](const CropOptions& options) {
    auto classifier = network::OnnxClassifier::load(*weights).value();
    const auto words = classes_of_crops(classifier->labels(), standard());
    return crop_finder(detector, std::move(classifier), words, options);
  };
  const auto finder = finder_of({});
  EXPECT_EQ(source_of(finder->fingerprint()), DetectionSource::kCrop);
  EXPECT_NE(finder->fingerprint(), finder_of({.margin = 1.5F})->fingerprint());
  EXPECT_THAT(finder->fingerprint(), HasSubstr(detector->fingerprint()));
  const auto photo = roomwise::testing::find_data("object_photos/n04380533_table_lamp.jpg");
  ROOMWISE_REQUIRE_FILE(photo);
  const auto found = finder->find(image::read_color(*photo).value());
  ASSERT_OK(found);
  ASSERT_FALSE(found->empty());
  EXPECT_EQ(standard().object_of(finder->labels()[found->front().label]), "lamp");
  EXPECT_GT(found->front().score, 0.8F);
}

}  // namespace
}  // namespace roomwise::objects
