#include "roomwise/pipeline/objects/proposal_detection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/fake_finder.h"
#include "roomwise/pipeline/testing/interrupted_at.h"
#include "roomwise/pipeline/testing/walk_with_box.h"

namespace roomwise::pipeline {
namespace {

using testing::BlindFinder;
using testing::DrawnBox;
using testing::InterruptedAt;
using testing::RedProposalClassifier;
using testing::WalkWithBox;

class CloserLooks : public ::testing::Test {
 protected:
  // Maps a walk past a red box, or goes on with it.
  Expected<MapSummary> map(home::Home& home, bool looks_closer, RunContext& run) {
    WalkWithBox walk(14, 0.05, kBox);
    objects::ObjectFinders finders;
    finders.in_pictures.push_back(std::make_unique<BlindFinder>());
    if (looks_closer) finders.of_proposals = std::make_unique<RedProposalClassifier>();
    return map_recording(walk,
                         {"walk", "made up", walk.info().camera, walk.info().frames_remaining},
                         home, {}, MapSettings{}, run, finders);
  }
  home::Home mapped(const std::string& name, bool looks_closer) {
    home::Home home = create_home(folder_ / name).value();
    EXPECT_OK(map(home, looks_closer, run_));
    return home;
  }

  const DrawnBox kBox{{Eigen::Vector3d(-0.2, -0.1, 0.9), Eigen::Vector3d(0.25, 0.35, 1.2)}};
  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(CloserLooks, NameWhatStandsByItselfAndNoFinderFound) {
  EXPECT_TRUE(mapped("without.home", false).instances()->empty());
  const home::Home home = mapped("with.home", true);
  const auto instances = home.instances();
  ASSERT_OK(instances);
  ASSERT_EQ(instances->size(), 1U);
  EXPECT_EQ(instances->front().name, "lamp");
  const auto keyframes = home.keyframes();
  ASSERT_OK(keyframes);
  const auto shows =
      std::ranges::find(*keyframes, instances->front().keyframe_id, &home::Keyframe::id);
  ASSERT_NE(shows, keyframes->end());
  const geometry::OrientedBox box = instances->front().box_world(shows->pose.world_from_keyframe);
  EXPECT_LT((box.center() - kBox.extent.center()).norm(), 0.2);
  EXPECT_EQ(home.looked_at(2)->size(), keyframes->size()) << "what it does not show was asked, too";
  const auto concepts = home.concepts();
  ASSERT_OK(concepts);
  const auto looks = home.detections(2);
  ASSERT_OK(looks);
  for (const auto& [keyframe, look] : *looks) {
    EXPECT_FALSE(look.coarse_depth.empty());
    for (const objects::Detection& region : look.detections) {
      EXPECT_EQ(concepts->vocabulary.object_of(region.label), "lamp");
      EXPECT_LE(region.score, 0.8 + 1e-6) << "views that show something else say nothing";
      EXPECT_GT(region.surface.points.size(), 8U);
    }
  }
}

TEST_F(CloserLooks, OnceMoreChangeNothing) {
  home::Home home = mapped("a.home", true);
  const auto before = home.content_digest();
  const auto looked = redetect_on_proposals(home, RedProposalClassifier(), run_);
  ASSERT_OK(looked);
  EXPECT_EQ(*home.content_digest(), *before);
}

TEST_F(CloserLooks, TakeThePlaceOfThoseOfOtherNetworks) {
  home::Home home = mapped("a.home", true);
  const auto before = home.content_digest();
  RedProposalClassifier other;
  other.word = "plant";
  ASSERT_OK(redetect_on_proposals(home, other, run_));
  EXPECT_NE(*home.content_digest(), *before);
  EXPECT_EQ(home.region_finders()->size(), 2U);
  ASSERT_OK(redetect_on_proposals(home, RedProposalClassifier(), run_));
  EXPECT_EQ(*home.content_digest(), *before);
}

TEST_F(CloserLooks, InterruptedOrFailingLeaveTheHomeAsItWas) {
  home::Home home = mapped("a.home", false);
  const auto before = home.content_digest();
  InterruptedAt interrupted("looking closer");
  RunContext run{pool_, interrupted, clock_};
  const auto looked = redetect_on_proposals(home, RedProposalClassifier(), run);
  EXPECT_ERROR(looked, "interrupted");
  EXPECT_EQ(looked.error().code, ErrorCode::kInterrupted);
  EXPECT_EQ(*home.content_digest(), *before);
  RedProposalClassifier failing;
  failing.fails = true;
  EXPECT_ERROR(redetect_on_proposals(home, failing, run_), "sees nothing");
  EXPECT_EQ(*home.content_digest(), *before);
}

TEST_F(CloserLooks, AMapThatIsInterruptedMeanwhileGoesOn) {
  const home::Home whole = mapped("whole.home", true);
  home::Home home = create_home(folder_ / "resumed.home").value();
  InterruptedAt interrupted("looking closer");
  RunContext run{pool_, interrupted, clock_};
  const auto stopped = map(home, true, run);
  ASSERT_OK(stopped);
  EXPECT_FALSE(stopped->finished);
  const auto resumed = map(home, true, run_);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->finished);
  EXPECT_EQ(*home.content_digest(), *whole.content_digest());
}

}  // namespace
}  // namespace roomwise::pipeline
