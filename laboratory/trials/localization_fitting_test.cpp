#include "laboratory/trials/localization_fitting.h"

#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::trials {
namespace {

// Poses whose inliers are as many, right or wrong; only what they cover of the picture tells.
PoseCase covering_case(const std::string& name, bool is_real, std::uint64_t seed) {
  PoseCase result{name, {name}, is_real, {}, {}, 0};
  RandomStream random(seed);
  for (int i = 0; i < 200; ++i) {
    const bool is_right = i % 4 != 0;
    const double coverage = is_right ? random.between(0.25, 0.6) : random.between(0.02, 0.2);
    result.evidence.push_back({std::log(random.between(10, 60)), std::log(random.between(0.1, 0.6)),
                               std::log(coverage), std::log(random.between(0.05, 0.6))});
    result.is_right.push_back(is_right);
  }
  result.pictures = 250;
  return result;
}

TEST(FitPoses, LearnsWhatTellsRightPosesFromWrongOnes) {
  const std::vector<PoseCase> cases{covering_case("a", true, 1), covering_case("b", false, 2)};
  const auto model = fit_poses(cases);
  ASSERT_OK(model);
  EXPECT_GT(model->weights[2], 1);
  const PoseCase unseen = covering_case("c", false, 3);
  const PoseCounts fitted = counts_of(unseen, *model), naive = naive_counts(unseen);
  EXPECT_EQ(fitted.pictures, 250U);
  EXPECT_GT(fitted.right, 2 * naive.right);
  EXPECT_LE(fitted.wrong * (naive.right + naive.wrong),
            naive.wrong * (fitted.right + fitted.wrong));
}

TEST(FitPoses, RealCasesWeighAsMuchAsSimulatedOnes) {
  // Three simulated cases say that coverage tells, one real one says the contrary, as strongly.
  PoseCase real = covering_case("real", true, 1);
  real.is_right.flip();
  std::vector<PoseCase> cases{real};
  for (std::uint64_t seed = 2; seed < 5; ++seed)
    cases.push_back(covering_case("simulated", false, seed));
  const auto model = fit_poses(cases);
  ASSERT_OK(model);
  EXPECT_LT(std::abs(model->weights[2]), 0.5);
}

TEST(FitPoses, NeedsRightPosesAndWrongOnes) {
  PoseCase all_right = covering_case("a", true, 1);
  all_right.is_right.assign(all_right.is_right.size(), true);
  EXPECT_ERROR(fit_poses({all_right, all_right}), "right ones and wrong ones");
  EXPECT_ERROR(fit_poses({covering_case("a", true, 1)}), "a: all cases share a source with it");
}

TEST(FitPoses, LeavesOutAllCasesOfASource) {
  // Two walks through a home, and one through another where all is seen smaller.
  PoseCase evening = covering_case("evening", true, 1), night = covering_case("night", true, 2);
  PoseCase other = covering_case("other", true, 3);
  for (mapping::PoseEvidence& evidence : other.evidence) evidence[2] -= std::log(20);
  for (PoseCase* one : {&evening, &night, &other}) {
    for (mapping::PoseEvidence& evidence : one->evidence) evidence[0] = std::log(30);
  }
  const auto threshold = [&] { return fit_poses({evening, night, other})->min_probability; };
  const double apart = threshold();
  evening.sources = night.sources = {"home"};
  EXPECT_NE(threshold(), apart) << "both walks are judged by the other home alone";
  // Pictures of this home on another are of both.
  PoseCase elsewhere = covering_case("elsewhere", true, 4);
  elsewhere.sources = {"home", "other"};
  const std::vector<PoseCase> all{evening, night, other, elsewhere};
  ASSERT_EQ(of_other_sources(all, evening).size(), 1U);
  EXPECT_EQ(of_other_sources(all, evening)[0].name, "other");
  EXPECT_EQ(of_other_sources(all, other).size(), 2U);
  EXPECT_TRUE(of_other_sources(all, elsewhere).empty());
}

TEST(PoseCase, NoPoseIsRightElsewhereAndPicturesWithoutAPoseCount) {
  LocalizationTrial near;
  near.answer.status = mapping::LocalizationStatus::kDoubtful;
  near.answer.inliers = 20;
  near.answer.matches = 40;
  near.answer.coverage = 0.2;
  near.error_m = 0.05;
  LocalizationTrial far = near, turned = near, none;
  far.error_m = 2;
  turned.error_rad = 0.5;
  none.answer.status = mapping::LocalizationStatus::kNoMotion;
  const PoseCase here = pose_case("a", {"a"}, false, false, {near, far, turned, none});
  EXPECT_EQ(here.pictures, 4U);
  EXPECT_EQ(here.is_right, (std::vector{true, false, false}));
  EXPECT_NEAR(here.evidence[0][0], std::log(20), 1e-12);
  EXPECT_EQ(pose_case("a", {"a"}, false, true, {near, far}).is_right, (std::vector{false, false}));
}

}  // namespace
}  // namespace roomwise::trials
