#include "roomwise/pipeline/rooms/room_recognizer.h"

#include <gmock/gmock.h>

#include "roomwise/home/testing/sample_home.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using rooms::LocalizationEvidence;
using rooms::PictureEvidence;
using rooms::Verdict;
using ::testing::HasSubstr;
using ::testing::Not;

// A recognizer of a hall and a kitchen, of pictures that have much red and much green. What
// pictures and places say is made up here.
class RoomRecognizerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    networks_.push_back(std::make_unique<testing::ColorNetwork>());
    const std::string& fingerprint = networks_.front()->fingerprint();
    home_.emplace(home::Home::create(folder_ / "a.home").value());
    home::Home& home = *home_;
    ROOMWISE_MUST(home.add_recording(home::testing::sample_recording()));
    ROOMWISE_MUST(home.add_network({networks_.front()->name(), fingerprint, {}, 12}));
    for (home::KeyframeId id = 0; id < 40; ++id) {
      home::MapCommit step = home::testing::sample_commit(1, 1, id);
      RandomStream random(id);
      std::vector<float> features(12);
      for (float& value : features) value = static_cast<float>(random.uniform());
      features[id < 20 ? 0 : 1] += 4;
      step.keyframes[0].predictions = {{1, {features, {}}}};
      step.keyframes[0].observations.clear();
      ROOMWISE_MUST(home.commit(step));
    }
    ROOMWISE_MUST(home.replace_concepts(rooms::Concepts::standard()));
    ROOMWISE_MUST(
        home.replace_rooms(std::vector<rooms::Room>{{"hall", "bedroom"}, {"kitchen", "kitchen"}}));
    ROOMWISE_MUST(home.replace_room_ranges(1, {{0, 59, "hall", 1}, {60, 119, "kitchen", 1}}));
    ThreadPool pool(1);
    SilentProgress progress;
    StageClock clock;
    RunContext run{pool, progress, clock};
    ASSERT_OK(learn_rooms_from_keyframes(home, {}, {}, {}, run));
    make_recognizer();
  }
  void make_recognizer() {
    auto made = RoomRecognizer::create(*home_, networks_);
    ASSERT_OK(made);
    recognizer_.emplace(*std::move(made));
  }

  static PictureEvidence picture(double hall, double known) {
    return {Eigen::Vector2d(hall, 1 - hall), known};
  }
  // Well known, and sure enough to be named.
  static PictureEvidence sure_hall() { return picture(0.999, 12); }
  static PictureEvidence open_question() { return picture(0.5, 12); }

  // Says what it was told to, and counts how often it was asked.
  RoomRecognizer::Localize place(double hall, double log_likelihood_ratio) {
    return [=, this]() -> Expected<LocalizationEvidence> {
      ++asked_;
      return LocalizationEvidence{Eigen::Vector2d(hall, 1 - hall), log_likelihood_ratio,
                                  "its place is told"};
    };
  }
  RoomRecognizer::Localize broken_place() {
    return []() -> Expected<LocalizationEvidence> { return fail("the depth image is damaged"); };
  }
  Expected<rooms::RoomDecision> decide(const PictureEvidence& picture,
                                       const RoomRecognizer::Localize& localize) {
    return recognizer_->decide(std::span(&picture, 1), {}, localize);
  }

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
  Networks networks_;
  std::optional<RoomRecognizer> recognizer_;
  int asked_ = 0;
};
using RoomRecognizerPlaces = RoomRecognizerTest;

TEST_F(RoomRecognizerTest, ANetworkWhoseFileIsAnotherNowIsRefusedInWords) {
  networks_.front() =
      std::make_unique<testing::ColorNetwork>(std::vector<std::string>{"lamp"});  // other weights
  EXPECT_ERROR(RoomRecognizer::create(*home_, networks_),
               "is not the one that this home was made with");
  networks_.clear();
  EXPECT_ERROR(RoomRecognizer::create(*home_, networks_), "give that file by --network");
}

TEST_F(RoomRecognizerPlaces, IsNotAskedWhereThePictureTellsTheRoom) {
  const auto decision = decide(sure_hall(), place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 0);
  EXPECT_EQ(decision->room(), "hall");
  EXPECT_THAT(decision->why, Not(HasSubstr("its place")));
}

TEST_F(RoomRecognizerPlaces, DecidesWhereThePictureLeavesRoomsOpen) {
  EXPECT_EQ(decide(open_question(), {})->verdict, Verdict::kEither);
  const auto decision = decide(open_question(), place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, HasSubstr("; its place is told"));
}

TEST_F(RoomRecognizerPlaces, MakesAHardlyKnownPictureKnown) {
  const PictureEvidence dark = picture(0.999, recognizer_->model().reject_log_odds - 1);
  EXPECT_EQ(decide(dark, {})->verdict, Verdict::kNoneOfThem);
  EXPECT_EQ(decide(dark, place(0.99, 7))->room(), "hall");
  EXPECT_EQ(asked_, 1);
}

TEST_F(RoomRecognizerPlaces, ThatThereIsNoneSpeaksAgainstThisHome) {
  const PictureEvidence hardly = picture(0.999, 4);
  EXPECT_EQ(decide(hardly, {})->room(), "hall");
  const auto decision = decide(hardly, place(0.5, -3));
  ASSERT_OK(decision);
  EXPECT_NE(decision->verdict, Verdict::kRoom);
  EXPECT_THAT(decision->why, HasSubstr("its place is told"));
}

TEST_F(RoomRecognizerPlaces, ThatContradictsAHardlyKnownPictureLeavesNoRoom) {
  const PictureEvidence hardly = picture(0.99, 4);
  EXPECT_EQ(decide(hardly, place(0.01, 5))->verdict, Verdict::kEither);
}

TEST_F(RoomRecognizerPlaces, WhatGoesWrongWhileLookingIsSaid) {
  EXPECT_ERROR(decide(open_question(), broken_place()), "depth image is damaged");
  EXPECT_OK(decide(sure_hall(), broken_place())) << "it is not asked";
  rooms::RoomStream stream = recognizer_->stream();
  EXPECT_ERROR(recognizer_->update(stream, open_question(), 1, broken_place()),
               "depth image is damaged");
}

TEST_F(RoomRecognizerPlaces, IsJoinedWithEveryPictureOfAWalkThatNeedsIt) {
  rooms::RoomStream stream = recognizer_->stream();
  auto decision = recognizer_->update(stream, open_question(), 1, place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, HasSubstr("; its place is told"));
  decision = recognizer_->update(stream, picture(0.001, 20), 1, place(0.99, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, Not(HasSubstr("its place")));
}

// ---- objects ----

const std::vector<std::string> kLabels{"four-poster", "microwave, microwave oven", "zebra", "horse",
                                       "dog"};

// Names a bed in red pictures and a microwave in others. Counts what it was shown.
class NamingNetwork final : public network::Classifier {
 public:
  NamingNetwork(std::string fingerprint, int& shown)
      : fingerprint_(std::move(fingerprint)), shown_(shown) {}
  [[nodiscard]] const std::string& name() const override { return fingerprint_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return kLabels; }
  [[nodiscard]] std::size_t feature_size() const override { return 0; }
  [[nodiscard]] Expected<network::Prediction> predict(
      const image::ColorImage& image) const override {
    ++shown_;
    const bool is_red = image.at(0, 0).r > image.at(0, 0).g;
    return network::Prediction{{},
                               {is_red ? 0.9F : 0.02F, is_red ? 0.02F : 0.9F, 0.03F, 0.03F, 0.02F}};
  }

 private:
  std::string fingerprint_;
  int& shown_;
};

class RoomRecognizerObjects : public RoomRecognizerTest {
 protected:
  void SetUp() override {
    RoomRecognizerTest::SetUp();
    networks_.push_back(std::make_unique<NamingNetwork>("names", shown_));
    make_recognizer();
  }
  static image::ColorImage red() { return {8, 8, Rgb8{250, 20, 20}}; }
  static image::ColorImage green() { return {8, 8, Rgb8{20, 250, 20}}; }

  // What the naming network says of the five labels; counts how often it is asked.
  RoomRecognizer::PredictLabels names(std::vector<float> scores) {
    return [=, this]() -> Expected<network::Prediction> {
      ++asked_;
      return network::Prediction{{}, scores};
    };
  }
  Expected<rooms::RoomDecision> decide_by(const PictureEvidence& picture,
                                          const RoomRecognizer::PredictLabels& update) {
    return recognizer_->decide(std::span(&picture, 1), update);
  }
  RoomRecognizer::PredictLabels sees_microwave() { return names({0, 0.9F, 0, 0, 0}); }

  int shown_ = 0;
};

TEST_F(RoomRecognizerObjects, ThePapersRuleTakesThoseOfTheSecondPictureOnly) {
  const auto second_green = recognizer_->paper_recognize(red(), green());
  ASSERT_OK(second_green);
  EXPECT_EQ(second_green->reason, rooms::Reason::kRepresentativeObject);
  EXPECT_EQ(second_green->object, "microwave");
  EXPECT_EQ(second_green->room, "kitchen");
  EXPECT_EQ(shown_, 1);
  const auto second_red = recognizer_->paper_recognize(green(), red());
  ASSERT_OK(second_red);
  EXPECT_EQ(second_red->object, "bed");
  EXPECT_EQ(second_red->room, "hall");
  EXPECT_EQ(shown_, 2);
  const auto alike = recognizer_->paper_recognize(red(), red());
  ASSERT_OK(alike);
  EXPECT_EQ(alike->reason, rooms::Reason::kFramesAgree);
  EXPECT_EQ(shown_, 2) << "no object is needed";
}

TEST_F(RoomRecognizerObjects, ThePapersRuleTakesTheTopThreeLabelsOnly) {
  const rooms::RoomScore hall{"hall", 0.9}, kitchen{"kitchen", 0.6};
  const auto third = recognizer_->paper_decide(hall, kitchen, names({0, 0.1F, 0.4F, 0.3F, 0.05F}));
  ASSERT_OK(third);
  EXPECT_EQ(third->object, "microwave");
  EXPECT_EQ(third->room, "kitchen");
  const auto fourth = recognizer_->paper_decide(hall, kitchen, names({0, 0.1F, 0.4F, 0.3F, 0.2F}));
  ASSERT_OK(fourth);
  EXPECT_EQ(fourth->reason, rooms::Reason::kHigherScore);
  EXPECT_EQ(fourth->room, "hall");
  EXPECT_EQ(asked_, 2);
}

TEST_F(RoomRecognizerObjects, AreLookedForOnlyWherePicturesAreKnownAndDoNotTellTheRoom) {
  const double reject = recognizer_->model().reject_log_odds;
  EXPECT_EQ(decide_by(sure_hall(), sees_microwave())->room(), "hall");
  EXPECT_EQ(asked_, 0) << "the picture tells the room";
  const double between = reject / 2;
  EXPECT_EQ(decide_by(picture(0.5, between), sees_microwave())->verdict, Verdict::kNotSure);
  EXPECT_EQ(decide_by(picture(0.5, reject - 1), sees_microwave())->verdict, Verdict::kNoneOfThem);
  EXPECT_EQ(asked_, 0) << "the pictures are not known";
  EXPECT_EQ(decide_by(open_question(), {})->verdict, Verdict::kEither);
  const auto decision = decide_by(open_question(), sees_microwave());
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->object, "microwave");
  EXPECT_EQ(decision->rooms.front().room, "kitchen");
  EXPECT_GT(decision->rooms.front().score, 0.75);
  EXPECT_LT(decision->rooms.front().score, 0.85) << "it is not trusted wholly";
}

TEST_F(RoomRecognizerObjects, AreNamedByTheNetworkThatLookedAtTheHome) {
  EXPECT_EQ(recognizer_->naming()->fingerprint(), "names") << "none has looked at it";
  // This one takes the hall for a kitchen, always; the one before it has looked at nothing.
  networks_.push_back(std::make_unique<NamingNetwork>("other", shown_));
  ROOMWISE_MUST(home_->add_network({"names", "names", kLabels, 0}));
  const auto other = home_->add_network({"other", "other", kLabels, 0});
  ASSERT_OK(other);
  ROOMWISE_MUST(home_->add_network({"newest", "not here", kLabels, 0}));
  for (home::KeyframeId id = 0; id < 40; ++id) {
    ASSERT_OK(home_->put_prediction(id, *other,
                                    {{}, {0, id < 20 ? 0.9F : 0.0F, id < 20 ? 0.0F : 0.9F, 0, 0}}));
  }
  make_recognizer();
  EXPECT_EQ(recognizer_->naming()->fingerprint(), "other");
  const auto decision = decide_by(open_question(), sees_microwave());
  ASSERT_OK(decision);
  EXPECT_EQ(decision->rooms.front().room, "hall") << "there it sees microwaves";
}

}  // namespace
}  // namespace roomwise::pipeline
