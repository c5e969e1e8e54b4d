#include "roomwise/pipeline/visits/update_home.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/fake_finder.h"
#include "roomwise/pipeline/testing/interrupted_at.h"
#include "roomwise/pipeline/testing/red_finder.h"
#include "roomwise/pipeline/testing/walk_with_box.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::pipeline {
namespace {

using testing::DrawnBox;
using testing::RedFinder;
using testing::WalkWithBox;

class UpdateHome : public ::testing::Test {
 protected:
  static constexpr int kFrames = 14;
  static constexpr double kStep_rad = 0.05;

  void SetUp() override {
    finders_.in_pictures.push_back(std::make_unique<RedFinder>());
    map_walk();
  }
  void map_walk() {
    WalkWithBox walk(kFrames, kStep_rad, kBox);
    Expected<home::Home> made = create_home(folder_ / "a.home");
    ASSERT_OK(made);
    home_.emplace(*std::move(made));
    ASSERT_OK(map_recording(walk,
                            {"walk", "made up", walk.info().camera, walk.info().frames_remaining},
                            *home_, {}, MapSettings{}, run_, finders_));
    ASSERT_EQ(home_->instances()->size(), 1U);
  }
  // Writes a later walk down and compares the home with it.
  Expected<HomeUpdate> visit(const std::optional<DrawnBox>& box) {
    const auto folder = folder_ / fmt::format("visit-{}", visits_++);
    ROOMWISE_RETURN_IF_ERROR(write_walk(folder, kFrames, kStep_rad, box));
    return compare(folder);
  }
  Expected<HomeUpdate> compare(const std::filesystem::path& folder,
                               const UpdateOptions& options = {}) {
    return compare(folder, options, run_);
  }
  Expected<HomeUpdate> compare(const std::filesystem::path& folder, const UpdateOptions& options,
                               RunContext& run) {
    ROOMWISE_TRY(const auto recording, recording::open_recording(folder));
    return compare_with_visit(*home_, {*recording, *recording}, finders_, {}, options, run);
  }
  static Expected<void> write_walk(const std::filesystem::path& folder, int frames, double step_rad,
                                   const std::optional<DrawnBox>& box) {
    WalkWithBox walk(frames, step_rad, box);
    ROOMWISE_TRY(auto writer, recording::TumWriter::create(folder, walk.info().camera));
    while (true) {
      ROOMWISE_TRY(auto frame, walk.next());
      if (!frame) break;
      ROOMWISE_RETURN_IF_ERROR(writer->write(*frame));
    }
    return writer->close();
  }

  inline static const DrawnBox kBox{
      {Eigen::Vector3d(-0.2, -0.1, 0.9), Eigen::Vector3d(0.25, 0.35, 1.2)}};
  inline static const DrawnBox kElsewhere{
      {Eigen::Vector3d(0.7, -0.1, 0.8), Eigen::Vector3d(1.1, 0.35, 1.1)}};

  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
  objects::ObjectFinders finders_;
  std::optional<home::Home> home_;
  int visits_ = 0;
};

TEST_F(UpdateHome, AVisitThatFindsAllAsItWasChangesNothing) {
  const auto update = visit(kBox);
  ASSERT_OK(update);
  EXPECT_TRUE(update->changes.empty());
  EXPECT_EQ(update->changes.visit.frames, static_cast<std::uint64_t>(kFrames));
  EXPECT_GE(update->changes.visit.placed, static_cast<std::uint64_t>(kFrames - 1));
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kThere);
  EXPECT_TRUE(update->unnamed.empty());
}

TEST_F(UpdateHome, WhatHasNoNameIsNoticedAllTheSame) {
  DrawnBox grey = kElsewhere;
  grey.color = {120, 120, 120};
  const auto update = visit(grey);
  ASSERT_OK(update);
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kRemoved);
  ASSERT_EQ(update->unnamed.size(), 1U) << "what is gone has a name";
  const UnnamedChange& change = update->unnamed[0];
  EXPECT_TRUE(change.is_new);
  EXPECT_LT(change.box_world.distance_m(kElsewhere.extent.center()), 0.25)
      << change.box_world.center().transpose();
  EXPECT_EQ(change.beside, "") << "the sofa went";
  ASSERT_OK(home_->apply_changes(update->changes));
  const auto again = visit(grey);
  ASSERT_OK(again);
  ASSERT_EQ(again->unnamed.size(), 1U) << "the sofa is known to be gone, the other is not kept";
  EXPECT_TRUE(again->unnamed[0].is_new);
}

TEST_F(UpdateHome, WhatMovedIsKeptInThePastAndNoticedOnce) {
  const auto first = visit(kElsewhere);
  ASSERT_OK(first);
  ASSERT_EQ(first->things.size(), 1U);
  EXPECT_EQ(first->things[0].state, objects::ChangeState::kMoved);
  ASSERT_OK(home_->apply_changes(first->changes));
  const auto past = home_->past_instances().value();
  ASSERT_EQ(past.size(), 1U);
  EXPECT_EQ(past[0].instance.name, "sofa");
  EXPECT_EQ(past[0].reason, home::PastReason::kMoved);
  EXPECT_GT(past[0].last_seen_ns, past[0].first_seen_ns);
  const auto instances = home_->instances().value();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].visit, 1);
  const auto pose = home_->keyframes()->at(instances[0].keyframe_id).pose.world_from_keyframe;
  // A sofa's box reaches further back than what was seen of it.
  EXPECT_LT(instances[0].box_world(pose).distance_m(kElsewhere.extent.center()), 0.1);

  const auto second = visit(kElsewhere);
  ASSERT_OK(second);
  EXPECT_TRUE(second->changes.empty()) << "the same once more is no change";
  EXPECT_TRUE(second->unnamed.empty()) << "the map's depth shows the sofa in its old place";
  // Joining all anew forgets nothing of it.
  ASSERT_OK(update_objects(*home_, {}));
  EXPECT_EQ(home_->instances()->size(), 1U);
  EXPECT_EQ(home_->instances()->at(0).visit, 1);

  const auto back = visit(kBox);
  ASSERT_OK(back);
  ASSERT_EQ(back->things.size(), 1U);
  EXPECT_EQ(back->things[0].state, objects::ChangeState::kMoved) << "it is carried back";
}

TEST_F(UpdateHome, WhatStandsWhereSomethingWasBroughtAndTakenAwayIsTold) {
  const auto moved = visit(kElsewhere);
  ASSERT_OK(moved);
  ASSERT_OK(home_->apply_changes(moved->changes));
  DrawnBox grey = kElsewhere;
  grey.extent.translate(Eigen::Vector3d(0.28, 0, 0));
  grey.color = {120, 120, 120};
  const auto update = visit(grey);
  ASSERT_OK(update);
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kRemoved);
  EXPECT_TRUE(std::ranges::any_of(update->unnamed, &UnnamedChange::is_new));
}

TEST_F(UpdateHome, WhatIsGoneStaysGone) {
  const auto update = visit(std::nullopt);
  ASSERT_OK(update);
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kRemoved);
  EXPECT_FALSE(update->things[0].now);
  ASSERT_OK(home_->apply_changes(update->changes));
  ASSERT_OK(update_objects(*home_, {}));
  EXPECT_TRUE(home_->instances()->empty());
  EXPECT_EQ(home_->past_instances()->size(), 1U);
}

// No finder sees the box in whole pictures: only region proposals, of what stands apart in depth.
class UpdateHomeByCloserLooks : public UpdateHome {
 protected:
  void SetUp() override {
    finders_.in_pictures.push_back(std::make_unique<testing::BlindFinder>());
    finders_.of_proposals = std::make_unique<testing::RedProposalClassifier>();
    map_walk();
  }
};

TEST_F(UpdateHomeByCloserLooks, WhatMovedIsKnownAgainByItsName) {
  const auto update = visit(kElsewhere);
  ASSERT_OK(update);
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].name, "lamp");
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kMoved);
  ASSERT_TRUE(update->things[0].now);
  EXPECT_LT(update->things[0].now->distance_m(kElsewhere.extent.center()), 0.1);
  EXPECT_TRUE(update->unnamed.empty()) << "it has a name";
}

TEST_F(UpdateHomeByCloserLooks, WithoutThemItIsGoneAndSomethingIsNew) {
  finders_.of_proposals.reset();
  const auto update = visit(kElsewhere);
  ASSERT_OK(update);
  ASSERT_EQ(update->things.size(), 1U);
  EXPECT_EQ(update->things[0].state, objects::ChangeState::kRemoved);
  ASSERT_EQ(update->unnamed.size(), 1U);
  EXPECT_TRUE(update->unnamed[0].is_new);
}

TEST_F(UpdateHomeByCloserLooks, WhatMovedIsThereOnceMore) {
  const auto first = visit(kElsewhere);
  ASSERT_OK(first);
  ASSERT_OK(home_->apply_changes(first->changes));
  const auto second = visit(kElsewhere);
  ASSERT_OK(second);
  EXPECT_TRUE(second->changes.empty());
  EXPECT_TRUE(second->unnamed.empty());
  ASSERT_OK(update_objects(*home_, {}));
  ASSERT_EQ(home_->instances()->size(), 1U);
  EXPECT_EQ(home_->instances()->at(0).visit, 1);
}

// Counts what it is shown.
class CountingProposalClassifier final : public objects::ProposalClassifier {
 public:
  [[nodiscard]] Expected<objects::ClassScores> look(const image::ColorImage& picture,
                                                    const network::PixelBox& box,
                                                    const objects::Proposal& thing) const override {
    const std::scoped_lock lock(mutex_);
    ++looks_;
    return red_.look(picture, box, thing);
  }
  [[nodiscard]] int looks() const { return looks_; }

 private:
  testing::RedProposalClassifier red_;
  mutable std::mutex mutex_;
  mutable int looks_ = 0;
};

TEST_F(UpdateHomeByCloserLooks, FramesAsFarApartAsKeyframesAreShownAndTheOthersNot) {
  const auto looks_of_walk = [&](int frames, double step_rad, std::uint64_t every) {
    const auto folder = folder_ / fmt::format("visit-{}", visits_++);
    EXPECT_OK(write_walk(folder, frames, step_rad, kElsewhere));
    auto proposal_classifier = std::make_unique<CountingProposalClassifier>();
    const CountingProposalClassifier& counting = *proposal_classifier;
    finders_.of_proposals = std::move(proposal_classifier);
    UpdateOptions options;
    options.visit.every = every;
    const auto update = compare(folder, options);
    EXPECT_OK(update);
    EXPECT_EQ(update->things.at(0).state, objects::ChangeState::kMoved);
    return counting.looks();
  };
  const int looks = looks_of_walk(kFrames, kStep_rad, 1);
  EXPECT_GE(looks, 3);
  // The same walk with four pictures for each, all of them or every second.
  EXPECT_LE(looks_of_walk(4 * kFrames, kStep_rad / 4, 1), looks + 2);
  EXPECT_LE(looks_of_walk(4 * kFrames, kStep_rad / 4, 2), looks + 2);
}

TEST_F(UpdateHomeByCloserLooks, InterruptedMeanwhileIsAnError) {
  testing::InterruptedAt interrupted("looking closer at the visit");
  RunContext run{pool_, interrupted, clock_};
  const auto folder = folder_ / "visit";
  ASSERT_OK(write_walk(folder, kFrames, kStep_rad, kElsewhere));
  EXPECT_ERROR(compare(folder, {}, run), "interrupted while looking closer at the visit");
}

TEST_F(UpdateHomeByCloserLooks, OneThatFailsIsAnError) {
  auto failing = std::make_unique<testing::RedProposalClassifier>();
  failing->fails = true;
  finders_.of_proposals = std::move(failing);
  EXPECT_ERROR(visit(kElsewhere), "sees nothing");
}

TEST_F(UpdateHome, GoesOnWithoutAPictureThatCannotBeReadWhereItIsToldTo) {
  const auto folder = folder_ / "damaged";
  ASSERT_OK(write_walk(folder, kFrames, kStep_rad, kBox));
  const auto picture = std::filesystem::directory_iterator(folder / "rgb")->path();
  ASSERT_OK(write_file(picture, std::string_view("no picture")));
  EXPECT_ERROR(compare(folder), picture.string());
  const auto recording = recording::open_recording(folder);
  ASSERT_OK(recording);
  recording::DamageTolerantSource whole(**recording, true);
  const auto update = compare_with_visit(*home_, {**recording, whole}, finders_, {}, {}, run_);
  ASSERT_OK(update);
  EXPECT_THAT(whole.damage(), ::testing::ElementsAre(::testing::HasSubstr(picture.string())));
  EXPECT_EQ(update->changes.visit.frames, std::uint64_t{kFrames - 1});
}

TEST_F(UpdateHome, OfALongVisitEvenlySpreadFramesAreLookedAt) {
  const auto folder = folder_ / "visit";
  ASSERT_OK(write_walk(folder, kFrames, kStep_rad, kBox));
  UpdateOptions options;
  options.visit.max_frames = 5;
  const auto update = compare(folder, options);
  ASSERT_OK(update);
  EXPECT_EQ(update->changes.visit.frames, 5U) << "every third of 14";
}

TEST_F(UpdateHome, SaysWhatIsMissing) {
  const auto folder = folder_ / "visit";
  ASSERT_OK(write_walk(folder, 2, kStep_rad, kBox));
  UpdateOptions options;
  options.visit.every = 0;
  EXPECT_ERROR(compare(folder, options), "every is 0");
  finders_.in_pictures.clear();
  EXPECT_ERROR(compare(folder), "no detector");
}

}  // namespace
}  // namespace roomwise::pipeline
