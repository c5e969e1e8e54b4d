#include "roomwise/pipeline/rooms/picture_features.h"

#include <gmock/gmock.h>

#include <atomic>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;

// Sees the mean of each colour, and counts how often it looks.
class MeanColor final : public network::Classifier {
 public:
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] std::string preprocessing() const override { return preprocessing_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] std::size_t feature_size() const override { return 3; }
  [[nodiscard]] Expected<network::Prediction> predict(
      const image::ColorImage& image) const override {
    ++looks_;
    std::vector<float> sums(3, 0);
    for (const Rgb8 pixel : image.pixels()) {
      sums[0] += pixel.r;
      sums[1] += pixel.g;
      sums[2] += pixel.b;
    }
    for (float& sum : sums) sum /= static_cast<float>(image.pixels().size());
    return network::Prediction{sums, {}};
  }
  void set_preprocessing(const std::string& preprocessing) { preprocessing_ = preprocessing; }
  // Since the last time.
  [[nodiscard]] int looks() const { return looks_.exchange(0); }

 private:
  std::string name_ = "mean";
  std::string fingerprint_ = "feed";
  std::string preprocessing_ = "mean 0";
  std::vector<std::string> labels_;
  mutable std::atomic<int> looks_ = 0;
};

class PictureFeaturesTest : public ::testing::Test {
 protected:
  PictureFeaturesTest() {
    for (std::uint8_t i = 0; i < 10; ++i) {
      image::ColorImage image(20, 15, {static_cast<std::uint8_t>(20 * i), 90, 30});
      image.at(3, i).b = 200;
      files_.push_back(image::encode_png(image));
    }
  }
  Expected<std::vector<std::vector<std::vector<float>>>> features(int first, int last,
                                                                  std::size_t count = 10) {
    const PictureSource source{count, [&](std::size_t i) { return files_[i]; },
                               [](std::size_t i) { return fmt::format("picture {}", i); }};
    return picture_features(home_, source, network_, {first, last}, run_);
  }

  ::roomwise::testing::ScratchFolder folder_;
  home::Home home_ = home::Home::create(folder_ / "a.home").value();
  std::vector<Bytes> files_;
  MeanColor network_;
  ThreadPool pool_{3};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(PictureFeaturesTest, LooksAtEveryVariantOnce) {
  const auto first = features(0, 2);
  ASSERT_OK(first);
  EXPECT_EQ(network_.looks(), 30);
  ASSERT_EQ(first->size(), 10u);
  ASSERT_EQ(first->front().size(), 3u);
  EXPECT_THAT((*first)[4][0], ElementsAre(80, 90, ::testing::FloatNear(30.6F, 0.1F)));
  EXPECT_NE((*first)[4][1], (*first)[4][0]);
  EXPECT_NE((*first)[4][1], (*first)[4][2]);

  EXPECT_EQ(features(0, 2).value(), *first);
  EXPECT_EQ(network_.looks(), 0) << "the home keeps what was seen";
  EXPECT_EQ(features(1, 3)->front().front(), first->front()[1]);
  EXPECT_EQ(network_.looks(), 10) << "only the new variant of each";
  EXPECT_EQ(features(0, 3)->front()[2], first->front()[2]);
  EXPECT_EQ(network_.looks(), 0);
}

TEST_F(PictureFeaturesTest, LooksAnewWherePicturesArePutInDifferently) {
  ASSERT_OK(features(0, 1));
  std::ignore = network_.looks();
  network_.set_preprocessing("mean 127.5");
  ASSERT_OK(features(0, 1));
  EXPECT_EQ(network_.looks(), 20) << "the same weights see something else";
  ASSERT_OK(features(0, 1));
  EXPECT_EQ(network_.looks(), 0);
}

TEST_F(PictureFeaturesTest, ForgetsWhatIsGone) {
  ASSERT_OK(features(0, 1));
  ASSERT_OK(features(0, 1, 4));
  EXPECT_EQ(home_.database().get<int>("SELECT count(*) FROM picture_features").value(), 8);
  std::ignore = network_.looks();
  ASSERT_OK(features(0, 1));
  EXPECT_EQ(network_.looks(), 12);
}

TEST_F(PictureFeaturesTest, APictureGivenTwiceIsKeptOnce) {
  files_[7] = files_[2];
  const auto seen = features(0, 1);
  ASSERT_OK(seen);
  EXPECT_EQ((*seen)[7], (*seen)[2]);
  EXPECT_EQ(home_.database().get<int>("SELECT count(*) FROM picture_features").value(), 18);
}

TEST_F(PictureFeaturesTest, APictureThatCannotBeReadKeepsWhatTheOthersGave) {
  const Bytes whole = files_[9];
  files_[9].resize(20);
  EXPECT_ERROR(features(0, 1), "picture 9: is a truncated or damaged PNG");
  files_[9] = whole;
  std::ignore = network_.looks();
  ASSERT_OK(features(0, 1));
  EXPECT_EQ(network_.looks(), 2);
}

TEST_F(PictureFeaturesTest, ABrokenPhotoIsNamed) {
  std::filesystem::create_directories(folder_ / "photos" / "hall");
  ASSERT_OK(write_file(folder_ / "photos" / "hall" / "a.png", files_[0]));
  ASSERT_OK(write_file(folder_ / "photos" / "hall" / "b.jpg", std::string_view("no picture")));
  EXPECT_ERROR(learn_rooms_from_photos(home_, folder_ / "photos", network_, {}, run_),
               "hall/b.jpg: is neither a JPEG nor a PNG nor a WebP picture");
}

TEST_F(PictureFeaturesTest, RefusesTooManyVariants) {
  EXPECT_ERROR(features(0, 17), "17 variants of each picture are wanted; expected 0 to 16");
}

TEST_F(PictureFeaturesTest, RoomsAreLearnedFromPhotosAndTheirVariants) {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const auto folder = folder_ / "photos" / (i < 5 ? "dark" : "red");
    std::filesystem::create_directories(folder);
    ASSERT_OK(write_file(folder / fmt::format("{}.png", i), files_[i]));
  }
  const RoomLearning learning{{}, 3};
  const auto report = learn_rooms_from_photos(home_, folder_ / "photos", network_, learning, run_);
  ASSERT_OK(report);
  EXPECT_EQ(report->held_out, 10u) << "variants are no pictures";
  EXPECT_EQ(network_.looks(), 40);
  const auto learned = home_.room_classifier().value();
  ASSERT_OK(learn_rooms_from_photos(home_, folder_ / "photos", network_, learning, run_));
  EXPECT_EQ(network_.looks(), 0);
  EXPECT_EQ(home_.room_classifier().value(), learned);
}

}  // namespace
}  // namespace roomwise::pipeline
