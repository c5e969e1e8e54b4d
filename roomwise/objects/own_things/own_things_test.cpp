// Things that a person shows, found again: known answers, invariances, faults.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/resample.h"
#include "roomwise/objects/own_things/own_thing_finder.h"
#include "roomwise/objects/own_things/placed_features.h"

namespace roomwise::objects {
namespace {

using ::testing::HasSubstr;

// Blots of random colours that no other seed makes: corners to match, colours to tell apart.
image::ColorImage blots(std::uint64_t seed, int side) {
  RandomStream random(seed, {7});
  image::ColorImage picture(side, side, {90, 90, 90});
  for (int blot = 0; blot < 60; ++blot) {
    const auto channel = [&] { return static_cast<std::uint8_t>(random.between(30, 250)); };
    const Rgb8 color{channel(), channel(), channel()};
    const int left = static_cast<int>(random.between(0, side)), size = 4 + blot % 14;
    const int top = static_cast<int>(random.between(0, side));
    for (int y = top; y < std::min(side, top + size); ++y) {
      for (int x = left; x < std::min(side, left + size); ++x) picture.at(x, y) = color;
    }
  }
  return picture;
}

image::ColorImage with(image::ColorImage picture, const image::ColorImage& thing, int left,
                       int top) {
  for (int y = 0; y < thing.height(); ++y) {
    for (int x = 0; x < thing.width(); ++x) picture.at(left + x, top + y) = thing.at(x, y);
  }
  return picture;
}

image::ColorImage room() {
  return image::resize(blots(99, 64), 640, 480);
}

image::ColorImage lit(image::ColorImage picture, double red, double green, double blue) {
  const auto scaled = [](std::uint8_t value, double by) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value * by), 0L, 255L));
  };
  for (Rgb8& pixel : picture.pixels()) {
    pixel = {scaled(pixel.r, red), scaled(pixel.g, green), scaled(pixel.b, blue)};
  }
  return picture;
}

image::ColorImage shown_in_middle(std::uint64_t seed) {
  return with(image::ColorImage(320, 240, {120, 120, 120}), blots(seed, 140), 90, 50);
}

// Sees the mean colour of each ninth.
class ColorNetwork final : public network::Classifier {
 public:
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] std::size_t feature_size() const override { return 27; }
  [[nodiscard]] Expected<network::Prediction> predict(
      const image::ColorImage& image) const override {
    const image::ColorImage small = image::resize(image, 3, 3);
    network::Prediction prediction;
    for (const Rgb8& pixel : small.pixels()) {
      for (const std::uint8_t value : {pixel.r, pixel.g, pixel.b}) {
        prediction.features.push_back(static_cast<float>(value) / 255 - 0.4F);
      }
    }
    return prediction;
  }

 private:
  std::string name_ = "colours";
  std::vector<std::string> labels_;
};

class OwnThingsTest : public ::testing::Test {
 protected:
  [[nodiscard]] PreparedThing taught(std::uint64_t seed) const {
    const auto shown = find_shown(shown_in_middle(seed));
    const std::vector<TaughtView> views{taught_view(*shown)};
    return finder_.prepare(views).value();
  }
  [[nodiscard]] OwnThingCandidate best(const image::ColorImage& picture,
                                       const PreparedThing& thing) const {
    return finder_.find(picture, {&thing, 1}).value().at(0);
  }
  ColorNetwork network_;
  DetectionFinders none_;
  OwnThingFinder finder_{network_, none_, {}, OwnThingModel::built_in()};
};

TEST_F(OwnThingsTest, AThingIsFoundWhereItIsHoweverLargeItIs) {
  const PreparedThing thing = taught(1);
  for (const int side : {90, 140, 200}) {
    const auto there = image::resize(blots(1, 140), side, side);
    const auto found = best(with(room(), there, 300, 200), thing);
    const network::PixelBox truth{300, 200, 300.F + static_cast<float>(side),
                                  200.F + static_cast<float>(side)};
    EXPECT_GT(network::intersection_over_union(found.box, truth), 0.4F) << side;
    EXPECT_GT(found.likeness[2], std::log(6)) << side;  // local features agree
  }
}

TEST_F(OwnThingsTest, ItIsLikelierWhereItIsThanWhereAnotherIs) {
  const PreparedThing thing = taught(1);
  const double itself = best(with(room(), blots(1, 140), 100, 150), thing).log_odds;
  const double another = best(with(room(), blots(2, 140), 100, 150), thing).log_odds;
  EXPECT_GT(itself, another + 2);
}

TEST_F(OwnThingsTest, OtherLightLeavesItFound) {
  const PreparedThing thing = taught(1);
  const auto picture = with(room(), blots(1, 140), 300, 200);
  for (const auto& light : {lit(picture, 0.5, 0.5, 0.5), lit(picture, 0.95, 0.75, 0.5)}) {
    const auto found = best(light, thing);
    EXPECT_GT(network::intersection_over_union(found.box, {300, 200, 440, 340}), 0.4F);
    EXPECT_GT(found.likeness[2], std::log(6));
  }
}

TEST_F(OwnThingsTest, ComparingTwiceGivesTheSameBits) {
  const PreparedThing thing = taught(1);
  const auto picture = with(room(), blots(1, 140), 300, 200);
  EXPECT_EQ(best(picture, thing).likeness, best(picture, thing).likeness);
}

TEST_F(OwnThingsTest, TheCostOfAPictureIsBoundedHoweverManyThingsAreTaught) {
  std::vector<PreparedThing> things;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) things.push_back(taught(seed));
  auto picture = finder_.begin(room()).value();
  const auto compared = finder_.compare(picture, things).value();
  EXPECT_LE(compared.size(), OwnThingSearch{}.max_boxes * things.size());
}

TEST_F(OwnThingsTest, ViewsAreChosenToDifferTheSharpestFirst) {
  std::vector<ShownThing> shown;
  for (const std::uint64_t seed : {1, 1, 1, 2}) {
    shown.push_back(find_shown(shown_in_middle(seed)).value());
  }
  shown[1].sharpness = 1;
  EXPECT_THAT(finder_.choose_views(shown, 2).value(), ::testing::ElementsAre(1, 3));
}

TEST(ShownThingTest, IsTheMiddleOfAPictureWithoutDepth) {
  const auto shown = find_shown(shown_in_middle(1));
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->crop.width(), 192);  // three fifths
  EXPECT_EQ(shown->crop.height(), 144);
}

TEST(ShownThingTest, IsWhatIsNearestWhereThereIsDepth) {
  image::DepthImage depth(320, 240, 1400);
  for (int y = 50; y < 190; ++y) {
    for (int x = 90; x < 230; ++x) depth.at(x, y) = 500;
  }
  const auto shown = find_shown(shown_in_middle(1), ShownDepth{depth, 1000});
  ASSERT_TRUE(shown);
  EXPECT_NEAR(shown->crop.width(), 162, 2);  // with a rim about it
  EXPECT_EQ(shown->mask.at(shown->mask.width() / 2, shown->mask.height() / 2), 255);
  EXPECT_EQ(shown->mask.at(1, 1), 0);
}

TEST(ShownThingTest, PicturesThatShowNothingAreRefusedWithWhatIsWrong) {
  const auto fault = [](const image::ColorImage& picture,
                        const std::optional<ShownDepth>& depth = {}) {
    const auto shown = find_shown(picture, depth);
    return shown ? std::string("taken") : std::string(name_of(shown.error()));
  };
  EXPECT_EQ(fault(shown_in_middle(1)), "taken");
  EXPECT_EQ(fault(lit(shown_in_middle(1), 0.1, 0.1, 0.1)), "dark");
  EXPECT_EQ(fault(image::ColorImage(320, 240, {255, 255, 255})), "glaring");
  EXPECT_EQ(fault(image::ColorImage(320, 240, {120, 120, 120})), "empty");
  EXPECT_EQ(fault(image::ColorImage()), "empty");
  const auto blurred = image::resize(image::resize(shown_in_middle(1), 20, 15), 320, 240);
  EXPECT_EQ(fault(blurred), "blurred");
  const image::DepthImage far(320, 240, 2500);
  EXPECT_EQ(fault(shown_in_middle(1), ShownDepth{far, 1000}), "far");
}

TEST(ShownThingTest, TheWidthOfAnEdgeIsThatOfItsBlur) {
  for (const double sigma_px : {1.0, 2.0, 4.0}) {
    image::GrayImage edge(80, 40);
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 80; ++x) {
        edge.at(x, y) = static_cast<std::uint8_t>(
            std::lround(20 + 100 * (1 + std::erf((x - 40) / (sigma_px * std::sqrt(2.0))))));
      }
    }
    EXPECT_NEAR(edge_width_px(edge), sigma_px, 0.5 * sigma_px);
  }
}

TEST(ShownThingTest, AViewComesBackFromItsFiles) {
  const auto shown = find_shown(shown_in_middle(1)).value();
  const auto again = shown_again(taught_view(shown)).value();
  EXPECT_EQ(again.mask, shown.mask);
  EXPECT_EQ(again.crop.width(), shown.crop.width());
}

TEST(OwnThingModelTest, BuiltInModelWeighsWhatSpeaksForAThing) {
  const OwnThingModel& model = OwnThingModel::built_in();
  EXPECT_GT(model.log_odds({0.6, 0.5, 3, 0.9}), model.log_odds({0.1, 0.1, 0, 0.9}) + model.margin);
  EXPECT_GT(model.margin, 0);
}

TEST(OwnThingModelTest, AModelThatIsDamagedIsNamed) {
  EXPECT_THAT(OwnThingModel::parse("{}").error().message, HasSubstr("bias"));
  EXPECT_THAT(OwnThingModel::parse(R"({"bias": 1, "margin": 1, "weights": {"embedding": 1}})")
                  .error()
                  .message,
              HasSubstr("embedding_mean"));
}

TEST(OwnThingModelTest, TheThresholdLiesAboveWhatIsUsualThoughSomePicturesShowTheThing) {
  OwnThingModel model;
  model.margin = 5;
  std::vector<double> scores(100, -3);
  for (int i = 0; i < 40; ++i) scores[static_cast<std::size_t>(i)] = 20;
  EXPECT_DOUBLE_EQ(found_threshold(scores, model).value(), 2);
  EXPECT_THAT(found_threshold({1, 2}, model).error().message, HasSubstr("20 do"));
}

}  // namespace
}  // namespace roomwise::objects
