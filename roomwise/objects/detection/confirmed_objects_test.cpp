#include "roomwise/objects/detection/confirmed_objects.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::objects {
namespace {

using geometry::RigidTransform;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<std::string> kLabels = {"banana", "studio couch, day bed", "four-poster",
                                          "table lamp", "stove"};

std::vector<std::string> names_of(const std::vector<ObjectScore>& observations) {
  std::vector<std::string> names;
  for (const ObjectScore& observation : observations) names.push_back(observation.object);
  return names;
}

TEST(SightingsIn, KeepsObjectsOfTheVocabularyOverTheThreshold) {
  const std::vector<float> scores = {0.9F, 0.1F, 0.1F, 0.5F, 0.25F};
  const auto vocabulary = ObjectVocabulary::standard();
  EXPECT_THAT(names_of(observations_in(scores, kLabels, vocabulary, 0.25)),
              ElementsAre("lamp", "stove"));
  EXPECT_THAT(names_of(observations_in(scores, kLabels, vocabulary, 0.26)), ElementsAre("lamp"));
}

TEST(SightingsIn, AnObjectHasTheHighestScoreOfItsLabels) {
  const std::vector<float> scores = {0, 0.5F, 0.75F, 0, 0};
  const auto observations = observations_in(scores, kLabels, ObjectVocabulary::standard(), 0.25);
  ASSERT_EQ(observations.size(), 1u);
  EXPECT_EQ(observations[0].object, "bed");
  EXPECT_DOUBLE_EQ(observations[0].score, 0.75);
}

TEST(TopObjects, LooksAtTheBestLabelsWhateverTheirScore) {
  const std::vector<float> scores = {0.5F, 0.02F, 0.01F, 0.03F, 0};
  const auto vocabulary = ObjectVocabulary::standard();
  EXPECT_THAT(names_of(top_objects(scores, kLabels, vocabulary, 1)), IsEmpty());
  EXPECT_THAT(names_of(top_objects(scores, kLabels, vocabulary, 3)), ElementsAre("lamp", "bed"));
  EXPECT_THAT(names_of(top_objects(scores, kLabels, vocabulary, 99)),
              ElementsAre("lamp", "bed", "stove"));
}

// Key-frames 0, 1, 2, ... that stand still at the world's origin, unless a test moves them.
class ConfirmObjectsTest : public ::testing::Test {
 protected:
  // Each element is the stove's score in a key-frame, 0 for not seen; all look at `point`.
  void see_stove(const std::vector<double>& scores, std::optional<Eigen::Vector3d> point) {
    for (const double score : scores) {
      KeyframeView view;
      view.keyframe_id = views_.size();
      if (score > 0) view.observations = {{"stove", score}};
      view.center_point = point;
      views_.push_back(view);
    }
  }
  std::vector<ConfirmedObject> confirm(const ObjectRules& rules = {}) {
    return confirm_objects(views_, rules, [&](std::uint64_t id) {
      return id == moved_keyframe_ ? world_from_moved_ : RigidTransform::identity();
    });
  }

  std::vector<KeyframeView> views_;
  std::uint64_t moved_keyframe_ = ~std::uint64_t{0};
  RigidTransform world_from_moved_;
  const Eigen::Vector3d here_{0, 0, 2};
  const Eigen::Vector3d far_{3, 0, 2};
};

TEST_F(ConfirmObjectsTest, FourKeyframesInARowConfirm) {
  see_stove({0.5, 0.5, 0.5, 0.5}, here_);
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].name, "stove");
  EXPECT_EQ(objects[0].observations, 4);
}

TEST_F(ConfirmObjectsTest, ThreeInARowOrFourWithAGapDoNot) {
  see_stove({0.5, 0.5, 0.5, 0, 0.5, 0.5, 0.5}, here_);
  EXPECT_THAT(confirm(), IsEmpty());
}

TEST_F(ConfirmObjectsTest, KnownGroundInBetweenEndsARow) {
  see_stove({0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, here_);
  views_[3].is_continuous = false;  // three here, three elsewhere
  EXPECT_THAT(confirm(), IsEmpty());
  views_[3].is_continuous = true;
  views_[2].is_continuous = false;  // two here, four elsewhere
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].observations, 4);
}

TEST_F(ConfirmObjectsTest, AWiderWindowForgivesAGap) {
  see_stove({0.5, 0.5, 0, 0.5, 0.5}, here_);
  ObjectRules rules;
  rules.window = 5;
  EXPECT_EQ(confirm(rules).size(), 1u);
}

TEST_F(ConfirmObjectsTest, ASightingUnderTheThresholdDoesNotCount) {
  see_stove({0.5, 0.5, 0.29, 0.5}, here_);
  EXPECT_THAT(confirm(), IsEmpty());
}

TEST_F(ConfirmObjectsTest, AnotherObjectDoesNotFillTheGap) {
  see_stove({0.5, 0.5, 0.5, 0.5}, here_);
  views_[2].observations = {{"bed", 0.5}};
  EXPECT_THAT(confirm(), IsEmpty());
}

TEST_F(ConfirmObjectsTest, TheBestKeyframeGivesThePlace) {
  see_stove({0.5, 0.6, 0.9, 0.9, 0.4}, here_);
  views_[2].center_point = far_;
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].keyframe_id, 2u) << "the first of equal ones";
  EXPECT_DOUBLE_EQ(objects[0].score, 0.9);
  EXPECT_EQ(objects[0].position_keyframe, far_);
}

TEST_F(ConfirmObjectsTest, TheBestKeyframeIsOneOfTheConfirmedOnes) {
  see_stove({0.99, 0, 0.5, 0.5, 0.5, 0.6, 0, 0.99}, here_);
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].keyframe_id, 5u);
}

TEST_F(ConfirmObjectsTest, WithoutDepthAtTheCentreThePlaceIsUnknown) {
  see_stove({0.5, 0.9, 0.5, 0.5}, here_);
  views_[1].center_point = std::nullopt;
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].position_keyframe, std::nullopt);
}

TEST_F(ConfirmObjectsTest, CloseRunsOfOneNameAreOneObject) {
  see_stove({0.5, 0.5, 0.5, 0.5, 0, 0, 0}, here_);
  see_stove({0.5, 0.8, 0.5, 0.5}, here_ + Eigen::Vector3d(0.5, 0, 0));
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].observations, 8);
  EXPECT_EQ(objects[0].keyframe_id, 8u) << "the better seen keeps its place";
}

TEST_F(ConfirmObjectsTest, DistantRunsAreTwoObjects) {
  see_stove({0.5, 0.5, 0.5, 0.5, 0, 0, 0}, here_);
  see_stove({0.5, 0.8, 0.5, 0.5}, far_);
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].keyframe_id, 0u) << "by name, then by key-frame";
  EXPECT_EQ(objects[1].keyframe_id, 8u);
}

TEST_F(ConfirmObjectsTest, ObjectsOfTwoNamesAtOnePlaceStayTwo) {
  see_stove({0.5, 0.5, 0.5, 0.5}, here_);
  for (KeyframeView& view : views_) view.observations.push_back({"fridge", 0.4});
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].name, "fridge");
  EXPECT_EQ(objects[1].name, "stove");
}

TEST_F(ConfirmObjectsTest, ThePlaceFollowsTheKeyframe) {
  // Drift put two observations of one stove 3 m apart; the optimised pose brings them together.
  see_stove({0.5, 0.5, 0.5, 0.5, 0, 0, 0}, here_);
  see_stove({0.5, 0.8, 0.5, 0.5}, far_);
  moved_keyframe_ = 8;
  world_from_moved_.translation = Eigen::Vector3d(-3, 0, 0);
  const auto objects = confirm();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].position_keyframe, far_) << "kept relative to its key-frame";
}

TEST_F(ConfirmObjectsTest, NothingSeenNothingConfirmed) {
  EXPECT_THAT(confirm(), IsEmpty());
  see_stove({0, 0, 0, 0, 0}, here_);
  EXPECT_THAT(confirm(), IsEmpty());
}

TEST(ObjectRules, NamesTheFieldThatIsWrong) {
  EXPECT_OK(ObjectRules{}.validate());
  ObjectRules rules;
  rules.min_score = 0;
  EXPECT_ERROR(rules.validate(), "min_score");
  rules = {};
  rules.window = 0;
  EXPECT_ERROR(rules.validate(), "window");
  rules = {};
  rules.min_observations = 5;
  EXPECT_ERROR(rules.validate(), "min_observations");
  rules = {};
  rules.same_object_distance_m = -1;
  EXPECT_ERROR(rules.validate(), "same_object_distance_m");
}

}  // namespace
}  // namespace roomwise::objects
