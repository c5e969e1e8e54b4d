#include "roomwise/mapping/frontend/loop_closer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(DrawLoopCandidates, DrawsFromThoseBeforeTheNeighbours) {
  LoopOptions options;
  options.neighbors = 3;
  options.random = 4;
  const std::vector<KeyframeId> drawn = sample_loop_candidates(20, options, RandomStream(1));
  EXPECT_EQ(drawn.size(), 4U);
  const std::set<KeyframeId> distinct(drawn.begin(), drawn.end());
  EXPECT_EQ(distinct.size(), 4U);
  EXPECT_LT(*distinct.rbegin(), 15U) << "19 is the newest, 18 belongs to the odometry";
}

TEST(DrawLoopCandidates, DrawsAllWhereThereAreFew) {
  LoopOptions options;
  options.neighbors = 2;
  options.random = 10;
  const std::vector<KeyframeId> drawn = sample_loop_candidates(6, options, RandomStream(1));
  EXPECT_EQ(std::set<KeyframeId>(drawn.begin(), drawn.end()), (std::set<KeyframeId>{0, 1}));
  EXPECT_THAT(sample_loop_candidates(4, options, RandomStream(1)), IsEmpty());
  EXPECT_THAT(sample_loop_candidates(1, options, RandomStream(1)), IsEmpty());
}

TEST(DrawLoopCandidates, PrefersEarlierKeyframes) {
  LoopOptions options;
  options.neighbors = 0;
  options.random = 1;
  options.age_preference = 4;
  int early = 0;
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const auto drawn =
        sample_loop_candidates(102, options, RandomStream(1, {static_cast<std::uint64_t>(i)}));
    early += drawn.at(0) < 50;
  }
  // Weights fall linearly from 4 to 1: the earlier half holds (4 + 2.5) / (4 + 2.5 + 2.5 + 1) of
  // them.
  EXPECT_NEAR(early / static_cast<double>(kDraws), 0.65, 0.03);
}

class CloseLoops : public ::testing::Test {
 protected:
  CloseLoops() {
    options_.neighbors = 2;
    options_.random = 0;
    options_.hit_neighbors = 0;
  }
  // Compares by a table of distances; key-frames that are not in it do not match.
  std::vector<KeyframeId> linked(const std::vector<KeyframeId>& neighbors,
                                 const std::vector<KeyframeId>& similar) {
    compared_.clear();
    const auto compare = [this](KeyframeId reference) -> Expected<motion::MotionOutcome> {
      if (reference == unreadable_) return fail("{} cannot be read", reference);
      compared_.push_back(reference);
      motion::MotionOutcome outcome;
      const auto match = matching_.find(reference);
      if (match == matching_.end()) return outcome;
      outcome.status = motion::MotionStatus::kFound;
      outcome.pose.reference_from_current.translation.x() = match->second;
      return outcome;
    };
    const auto edges = close_loops({39, 390, 0}, options_, neighbors, similar, compare, 1);
    error_ = edges ? "" : edges.error().message;
    std::vector<KeyframeId> from;
    for (const PoseGraphEdge& edge : edges.value_or(std::vector<PoseGraphEdge>())) {
      EXPECT_EQ(edge.to, 39U);
      EXPECT_TRUE(edge.is_robust);
      EXPECT_EQ(edge.from_from_to.translation.x(), matching_.at(edge.from));
      from.push_back(edge.from);
    }
    return from;
  }
  LoopOptions options_;
  std::map<KeyframeId, double> matching_;
  std::optional<KeyframeId> unreadable_;
  std::vector<KeyframeId> compared_;
  std::string error_;
};

TEST_F(CloseLoops, LinksEveryNeighbourAndSimilarKeyframeThatMatches) {
  matching_ = {{37, 0.1}, {12, 0.2}, {5, 0.3}, {20, 0.4}};
  EXPECT_THAT(linked({37, 36}, {12, 9, 5}), ElementsAre(5, 12, 37));
  EXPECT_THAT(compared_, ::testing::UnorderedElementsAre(37, 36, 12, 9, 5));
}

TEST_F(CloseLoops, ComparesEachKeyframeOnce) {
  matching_ = {{37, 0.1}};
  EXPECT_THAT(linked({37, 36}, {37, 36, 37}), ElementsAre(37));
  EXPECT_THAT(compared_, ElementsAre(37, 36));
}

TEST_F(CloseLoops, ExploresAroundARandomHitForTheNearest) {
  options_.neighbors = 0;
  options_.random = 37;  // all but the last two, in some order
  options_.hit_neighbors = 1;
  matching_ = {{10, 0.5}, {11, 0.2}, {30, 0.4}};
  EXPECT_THAT(linked({}, {}), ElementsAre(11, 30));
}

TEST_F(CloseLoops, PassesOnWhyAComparisonFailed) {
  matching_ = {{37, 0.1}, {36, 0.2}};
  unreadable_ = 36;
  EXPECT_THAT(linked({37, 36}, {}), IsEmpty());
  EXPECT_EQ(error_, "36 cannot be read");
}

TEST(IsReturn, TellsAReturnFromANeighbour) {
  const geometry::Matrix6d information = geometry::Matrix6d::Identity();
  EXPECT_TRUE(spans_long_loop({2, 40, {}, information, true}));
  EXPECT_FALSE(spans_long_loop({37, 40, {}, information, true}));
  EXPECT_FALSE(spans_long_loop({2, 40, {}, information, false}));
}

TEST(LoopOptions, SaysWhichFieldIsWrong) {
  LoopOptions options;
  EXPECT_OK(options.validate());
  options.age_preference = 0.5;
  EXPECT_ERROR(options.validate(), "age_preference");
  options = {};
  options.similar = -1;
  EXPECT_ERROR(options.validate(), "similar = -1");
}

TEST(EdgeFromMotion, NeverClaimsMoreThanTheSystematicErrorAllows) {
  motion::RefinedPose pose;
  pose.information = 1e12 * geometry::Matrix6d::Identity();
  const PoseGraphEdge edge = edge_from_motion(3, 4, pose, false);
  EXPECT_LT(edge.information(0, 0), 1 / (0.0039 * 0.0039));
  pose.information = geometry::Matrix6d::Identity();
  EXPECT_NEAR(edge_from_motion(3, 4, pose, false).information(0, 0), 1, 1e-3)
      << "weak measurements stay as they are";
  pose.information.setZero();
  EXPECT_TRUE(edge_from_motion(3, 4, pose, false).information.isZero());
}

TEST(EdgeThroughFrame, LeadsFromOneKeyframeToTheOther) {
  motion::RefinedPose in_from;
  in_from.reference_from_current = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized())),
      {0.1, -0.2, 0.3}};
  motion::RefinedPose in_to;
  in_to.reference_from_current = {
      Eigen::Quaterniond(Eigen::AngleAxisd(-0.7, Eigen::Vector3d(2, 0, 1).normalized())),
      {1.5, 0.4, -0.6}};
  // The frame's pose in `from` is uncertain, that in `to` nearly certain.
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 0.02, 0.03, 0.05, 0.01, 0.02, 0.03;
  in_from.information = sigma.array().pow(-2).matrix().asDiagonal();
  in_to.information = 1e10 * geometry::Matrix6d::Identity();
  const PoseGraphEdge edge = edge_through_frame(3, in_from, 8, in_to);
  EXPECT_EQ(edge.from, 3U);
  EXPECT_EQ(edge.to, 8U);
  EXPECT_TRUE(edge.is_robust);
  const geometry::RigidTransform way =
      in_from.reference_from_current * in_to.reference_from_current.inverse();
  EXPECT_LT((edge.from_from_to.inverse() * way).distance_m(), 1e-12);

  // The covariance it claims is the one that the frame's errors give, drawn at random.
  RandomStream random(5);
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const auto draw = [&](int k) { return sigma[k] * random.normal(); };
    const Eigen::Vector3d shift(draw(0), draw(1), draw(2));
    const Eigen::Vector3d half_turn(draw(3), draw(4), draw(5));
    const geometry::RigidTransform error{
        Eigen::Quaterniond(std::sqrt(1 - half_turn.squaredNorm()), half_turn.x(), half_turn.y(),
                           half_turn.z()),
        shift};
    const geometry::RigidTransform wrong =
        in_from.reference_from_current * error * in_to.reference_from_current.inverse();
    const geometry::RigidTransform difference = edge.from_from_to.inverse() * wrong;
    Eigen::Matrix<double, 6, 1> e;
    e << difference.translation, difference.rotation.vec();
    covariance += e * e.transpose() / kDraws;
  }
  const geometry::Matrix6d claimed = edge.information.inverse();
  EXPECT_LT((claimed - covariance).norm(), 0.05 * covariance.norm());
}

}  // namespace
}  // namespace roomwise::mapping
