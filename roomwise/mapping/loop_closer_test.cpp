#include "roomwise/mapping/loop_closer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "roomwise/base/testing.h"

namespace roomwise::mapping {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(DrawLoopCandidates, TakesTheNeighboursAndDrawsFromTheRest) {
  LoopOptions options;
  options.neighbors = 3;
  options.random = 4;
  const LoopCandidates candidates = draw_loop_candidates(20, options, RandomStream(1));
  EXPECT_THAT(candidates.neighbors, ElementsAre(17, 16, 15))
      << "19 is the newest, 18 belongs to the odometry";
  EXPECT_EQ(candidates.random.size(), 4U);
  const std::set<KeyframeId> distinct(candidates.random.begin(), candidates.random.end());
  EXPECT_EQ(distinct.size(), 4U);
  EXPECT_LT(*distinct.rbegin(), 15U);
}

TEST(DrawLoopCandidates, TriesAllWhereThereAreFew) {
  LoopOptions options;
  options.neighbors = 2;
  options.random = 10;
  const LoopCandidates candidates = draw_loop_candidates(6, options, RandomStream(1));
  EXPECT_THAT(candidates.neighbors, ElementsAre(3, 2));
  EXPECT_EQ(std::set<KeyframeId>(candidates.random.begin(), candidates.random.end()),
            (std::set<KeyframeId>{0, 1}));
  EXPECT_THAT(draw_loop_candidates(2, options, RandomStream(1)).neighbors, IsEmpty());
}

TEST(DrawLoopCandidates, PrefersEarlierKeyframes) {
  LoopOptions options;
  options.neighbors = 0;
  options.random = 1;
  options.earliest_preference = 4;
  int early = 0;
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const auto drawn =
        draw_loop_candidates(102, options, RandomStream(1, {static_cast<std::uint64_t>(i)}));
    early += drawn.random.at(0) < 50;
  }
  // Weights fall linearly from 4 to 1: the earlier half holds (4 + 2.5) / (4 + 2.5 + 2.5 + 1) of
  // them.
  EXPECT_NEAR(early / static_cast<double>(kDraws), 0.65, 0.03);
}

class CloseLoops : public ::testing::Test {
 protected:
  CloseLoops() {
    for (KeyframeId id = 0; id < 40; ++id)
      keyframes_.push_back({id, 10 * id, 0, motion::MeasuredFeatures{}});
    options_.neighbors = 2;
    options_.random = 0;
    options_.explored = 0;
  }
  // Compares by a table of distances; key-frames that are not in it do not match.
  std::vector<KeyframeId> linked(const std::vector<KeyframeId>& similar) {
    compared_.clear();
    const auto compare = [this](const Keyframe& reference, const motion::FrameMeasurements&,
                                std::uint64_t frame_index) {
      EXPECT_EQ(frame_index, 390U) << "the newest";
      compared_.push_back(reference.id);
      motion::MotionOutcome outcome;
      const auto match = matching_.find(reference.id);
      if (match == matching_.end()) return outcome;
      outcome.status = motion::MotionStatus::kFound;
      outcome.pose.reference_from_current.translation.x() = match->second;
      return outcome;
    };
    std::vector<KeyframeId> from;
    for (const PoseGraphEdge& edge : close_loops(keyframes_, options_, similar, compare, 1)) {
      EXPECT_EQ(edge.to, 39U);
      EXPECT_TRUE(edge.is_loop);
      EXPECT_EQ(edge.from_from_to.translation.x(), matching_.at(edge.from));
      from.push_back(edge.from);
    }
    return from;
  }
  std::vector<Keyframe> keyframes_;
  LoopOptions options_;
  std::map<KeyframeId, double> matching_;
  std::vector<KeyframeId> compared_;
};

TEST_F(CloseLoops, LinksEveryNeighbourAndSimilarKeyframeThatMatches) {
  matching_ = {{37, 0.1}, {12, 0.2}, {5, 0.3}, {20, 0.4}};
  EXPECT_THAT(linked({12, 9, 5}), ElementsAre(5, 12, 37));
  EXPECT_THAT(compared_, ::testing::UnorderedElementsAre(37, 36, 12, 9, 5));
}

TEST_F(CloseLoops, ComparesEachKeyframeOnce) {
  matching_ = {{37, 0.1}};
  EXPECT_THAT(linked({37, 36, 37}), ElementsAre(37));
  EXPECT_THAT(compared_, ElementsAre(37, 36));
}

TEST_F(CloseLoops, ExploresAroundARandomHitForTheNearest) {
  options_.neighbors = 0;
  options_.random = 37;  // all but the last two, in some order
  options_.explored = 1;
  matching_ = {{10, 0.5}, {11, 0.2}, {30, 0.4}};
  EXPECT_THAT(linked({}), ElementsAre(11, 30));
}

TEST(IsReturn, TellsAReturnFromANeighbour) {
  const geometry::Matrix6d information = geometry::Matrix6d::Identity();
  EXPECT_TRUE(is_return({2, 40, {}, information, true}));
  EXPECT_FALSE(is_return({37, 40, {}, information, true}));
  EXPECT_FALSE(is_return({2, 40, {}, information, false}));
}

TEST(LoopOptions, SaysWhichFieldIsWrong) {
  LoopOptions options;
  EXPECT_OK(options.validate());
  options.earliest_preference = 0.5;
  EXPECT_ERROR(options.validate(), "earliest_preference");
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

}  // namespace
}  // namespace roomwise::mapping
