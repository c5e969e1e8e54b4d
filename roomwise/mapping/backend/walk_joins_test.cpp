#include "roomwise/mapping/backend/walk_joins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;
using ::testing::SizeIs;

constexpr std::size_t kOfWalk = 10;
constexpr std::array<std::size_t, 2 * kOfWalk> kWalkOf{0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                       1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

// Two walks of ten key-frames each along the same arc, the second some way beside the first.
class WalkJoins : public ::testing::Test {
 protected:
  WalkJoins() {
    Vector6d step;
    step << 0.02, 0.12, -0.01, 0.2, 0.02, 0.3;
    const RigidTransform beside({1, 0, 0, 0}, {0.3, 0, 0.1});
    RigidTransform pose;
    for (std::size_t i = 0; i < kOfWalk; ++i) {
      truth_[i] = pose;
      truth_[kOfWalk + i] = pose * beside;
      pose = pose * RigidTransform::exp(step);
    }
    for (KeyframeId to = 1; to < 2 * kOfWalk; ++to) {
      if (to != kOfWalk) add(to - 1, to, false);
    }
    within_ = edges_.size();
  }

  void add(KeyframeId from, KeyframeId to, bool is_robust, const RigidTransform& error = {}) {
    edges_.push_back({from, to, truth_[from].inverse() * truth_[to] * error,
                      1e4 * Matrix6d::Identity(), is_robust});
  }
  // The number of edges between the walks that are left.
  [[nodiscard]] std::size_t joins_left(const WalkJoinOptions& options = {}) const {
    const auto kept = without_unsupported_joins(kWalkOf, edges_, {}, options);
    EXPECT_TRUE(kept.has_value());
    EXPECT_GE(kept->size(), within_) << "what is measured within a walk stays";
    return kept->size() - within_;
  }

  // The same, of those that views are asked about.
  [[nodiscard]] std::size_t joins_left_by(const CompareDepths& compare,
                                          const WalkJoinOptions& options = {}) const {
    const auto solution = solve_map(2 * kOfWalk, edges_);
    EXPECT_OK(solution);
    const auto kept = without_contradicted_joins(kWalkOf, edges_, *solution, compare, options);
    EXPECT_OK(kept);
    EXPECT_GE(kept->size(), within_);
    return kept->size() - within_;
  }

  std::array<RigidTransform, 2 * kOfWalk> truth_;
  std::vector<PoseGraphEdge> edges_;
  std::size_t within_ = 0;
};

RigidTransform wrong_place() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {0.4, -0.1, 0.3}};
}

TEST_F(WalkJoins, ThreeThatAgreeAreBelieved) {
  add(0, 10, true);
  add(2, 12, true);
  EXPECT_EQ(joins_left(), 0U) << "two are too few";
  add(14, 5, true);  // whichever way round
  EXPECT_EQ(joins_left(), 3U);
}

// The first walk and the third are one part of the map: of what joins it with the second, some
// begins at the key-frame with the lower number and some at the other.
TEST_F(WalkJoins, ThoseOfAWalkBetweenTwoOthersCountTogether) {
  constexpr std::array<std::size_t, 2 * kOfWalk> kPartOf{0, 0, 0, 0, 0, 1, 1, 1, 1, 1,
                                                         1, 1, 1, 1, 1, 0, 0, 0, 0, 0};
  edges_.clear();
  for (KeyframeId to = 1; to < 2 * kOfWalk; ++to) {
    if (kPartOf[to - 1] == kPartOf[to]) add(to - 1, to, false);
  }
  add(4, 15, false);
  const std::size_t within = edges_.size();
  add(0, 5, true);
  add(2, 7, true);
  add(12, 16, true);
  add(13, 18, true);
  const auto kept = without_unsupported_joins(kPartOf, edges_);
  ASSERT_OK(kept);
  EXPECT_EQ(kept->size(), within + 4);
}

TEST_F(WalkJoins, OneThatContradictsTheOthersGoes) {
  for (const KeyframeId id : {0U, 3U, 6U}) add(id, kOfWalk + id, true);
  add(5, 15, true, wrong_place());
  EXPECT_EQ(joins_left(), 3U);
}

TEST_F(WalkJoins, WrongOnesDoNotAgreeWithEachOther) {
  for (const KeyframeId id : {0U, 3U, 6U, 8U}) {
    const auto far = static_cast<double>(id);
    add(id, kOfWalk + id, true, RigidTransform({1, 0, 0, 0}, {0.4 * far, 0, 0.5}) * wrong_place());
  }
  EXPECT_EQ(joins_left(), 0U);
}

TEST_F(WalkJoins, OneKeyframeOfAWalkIsNotSeveralWitnesses) {
  for (const KeyframeId id : {10U, 11U, 12U, 13U}) add(4, id, true);
  EXPECT_EQ(joins_left(), 0U);
}

TEST_F(WalkJoins, DriftBetweenTheEndsIsForgiven) {
  const auto drift = [](double m) { return RigidTransform({1, 0, 0, 0}, {m, 0, 0}); };
  add(0, 10, true);
  add(4, 14, true, drift(0.08));
  add(9, 19, true, drift(0.15));
  EXPECT_EQ(joins_left(), 3U);
  EXPECT_EQ(joins_left({.max_distance_m = 0.02, .max_drift = 0}), 0U);
}

TEST_F(WalkJoins, OneWalkKeepsAllItsEdges) {
  add(0, 8, true, wrong_place());
  const auto kept = without_unsupported_joins(std::array<std::size_t, 2 * kOfWalk>{}, edges_);
  ASSERT_OK(kept);
  EXPECT_THAT(*kept, SizeIs(edges_.size()));
}

// Views of which each pair overlaps and agrees by so much.
CompareDepths all_views(const motion::ViewAgreement& agreement) {
  return [agreement](KeyframeId, KeyframeId, const RigidTransform&) { return agreement; };
}

TEST_F(WalkJoins, ViewsThatShowDifferentPlacesForbidThem) {
  for (const KeyframeId id : {0U, 3U, 6U}) add(id, kOfWalk + id, true);
  EXPECT_EQ(joins_left_by(all_views({.overlap = 0.6, .agreeing = 0.95, .in_front = 0.05})), 3U);
  EXPECT_EQ(joins_left_by(all_views({.overlap = 0.6, .agreeing = 0.5, .in_front = 0.5})), 0U);
  EXPECT_EQ(joins_left_by(all_views({.overlap = 0.6, .agreeing = 0.7, .seen_through = 0.3})), 0U);
  EXPECT_EQ(joins_left_by(all_views({.overlap = 0.1, .agreeing = 0.2})), 3U)
      << "that is too little to say so";
}

TEST_F(WalkJoins, ViewsAreComparedWhereTheSolutionPutsThem) {
  for (const KeyframeId id : {0U, 3U, 6U}) add(id, kOfWalk + id, true);
  std::size_t compared = 0;
  const CompareDepths compare = [&](KeyframeId reference, KeyframeId current,
                                    const RigidTransform& reference_from_current) {
    ++compared;
    EXPECT_NE(kWalkOf[reference], kWalkOf[current]);
    const RigidTransform apart =
        reference_from_current.inverse() * truth_[reference].inverse() * truth_[current];
    EXPECT_LT(apart.distance_m() + apart.angle_rad(), 1e-6);
    return motion::ViewAgreement{.overlap = 0.5, .agreeing = 1};
  };
  EXPECT_EQ(joins_left_by(compare), 3U);
  EXPECT_GT(compared, kOfWalk);
  compared = 0;
  EXPECT_EQ(joins_left_by(compare, {.max_compared = 2, .max_nearest = 1}), 3U);
  EXPECT_EQ(compared, 4U) << "two key-frames with one each, both ways";
}

// The first of three parts, ten key-frames long, is joined rightly with the second, that with the
// third, and by one wrong edge the first with the third, which bends the others.
TEST_F(WalkJoins, AWrongJoinInARingDoesNotTakeTheRightOnesWithIt) {
  constexpr std::array<std::size_t, 2 * kOfWalk> kPartOf{0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                         1, 1, 1, 1, 1, 2, 2, 2, 2, 2};
  std::erase_if(edges_, [](const PoseGraphEdge& edge) { return edge.to == 15; });
  for (const KeyframeId id : {0U, 2U, 4U}) add(id, kOfWalk + id, false);
  for (const KeyframeId id : {12U, 13U, 14U}) add(id, id + 3, false);
  add(7, 17, false, RigidTransform({1, 0, 0, 0}, {0.6, 0.4, 0}) * wrong_place());
  const PoseGraphEdge wrong = edges_.back();
  // Of what overlaps half agrees where they are this far from where they are in truth.
  constexpr double kHalf_m = 0.02;
  const CompareDepths compare = [&](KeyframeId reference, KeyframeId current,
                                    const RigidTransform& reference_from_current) {
    const RigidTransform apart =
        reference_from_current.inverse() * truth_[reference].inverse() * truth_[current];
    const double agreeing = kHalf_m / (kHalf_m + apart.distance_m());
    return motion::ViewAgreement{.overlap = 0.5, .agreeing = agreeing, .in_front = 1 - agreeing};
  };
  const auto judged = [&](const std::vector<PoseGraphEdge>& edges) {
    const auto solution = solve_map(kPartOf.size(), edges);
    EXPECT_OK(solution);
    return without_contradicted_joins(kPartOf, edges, *solution, compare);
  };
  const auto bent = solve_map(kPartOf.size(), edges_);
  ASSERT_OK(bent);
  const auto& poses = bent->world_from_keyframe;
  ASSERT_LT(compare(4, 14, poses[4].inverse() * poses[14]).agreeing, 0.6)
      << "a right one looks wrong beside the wrong one";
  const auto kept = judged(edges_);
  ASSERT_OK(kept);
  EXPECT_THAT(*kept, SizeIs(edges_.size() - 1));
  EXPECT_TRUE(std::ranges::none_of(*kept, [&](const PoseGraphEdge& edge) {
    return edge.from == wrong.from && edge.to == wrong.to;
  }));
  const auto again = judged(*kept);
  ASSERT_OK(again);
  EXPECT_THAT(*again, SizeIs(kept->size()));
}

TEST_F(WalkJoins, SaysWhichOptionIsWrong) {
  EXPECT_ERROR((WalkJoinOptions{.min_agreeing_edges = 0}.validate()), "min_agreeing_edges");
  EXPECT_ERROR((WalkJoinOptions{.max_drift = -1}.validate()), "max_drift");
  EXPECT_OK(WalkJoinOptions{}.validate());
}

}  // namespace
}  // namespace roomwise::mapping
