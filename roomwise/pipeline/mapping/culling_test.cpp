#include "roomwise/pipeline/mapping/culling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_coverage.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/interrupted_at.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using testing::SyntheticWalk;

// A room that is walked through three times, the second and third time a little beside the first.
class Culling : public ::testing::Test {
 protected:
  static constexpr int kFrames = 45;

  static SyntheticWalk walk(int which) {
    SyntheticWalk walk(kFrames, 0.05, 0.012 * which);
    walk.begins_ns += 1'000'000'000'000LL * which;
    return walk;
  }

  Expected<MapSummary> map(const std::filesystem::path& file, int which,
                           Progress* progress = nullptr) {
    ROOMWISE_TRY(home::Home home,
                 std::filesystem::exists(file) ? home::Home::open(file) : home::Home::create(file));
    SyntheticWalk source = walk(which);
    ThreadPool pool(2);
    StageClock clock;
    RunContext run{pool, progress != nullptr ? *progress : silent_, clock};
    return map_recording(source, {source.info().name, "made up", source.info().camera, kFrames},
                         home, {}, settings_, run);
  }

  // A copy of a home with two walks, which is mapped once.
  std::filesystem::path home_of_two(const std::string& name) {
    static const roomwise::testing::ScratchFolder kept;
    const auto file = kept / "two.home";
    if (!std::filesystem::exists(file)) {
      for (const int which : {0, 1}) EXPECT_OK(map(file, which));
    }
    std::filesystem::copy(file, folder_ / name);
    return folder_ / name;
  }

  CullingVerdicts judge(const home::Home& home, home::RecordingId walk) {
    ThreadPool pool(2);
    StageClock clock;
    RunContext run{pool, silent_, clock};
    auto verdicts = judge_keyframes(home, walk, {}, run);
    EXPECT_OK(verdicts);
    return *std::move(verdicts);
  }

  static std::string digest(const std::filesystem::path& file) {
    return home::Home::open_read_only(file)->content_digest().value();
  }

  // How far frames of two trajectories of the same walks are apart at most, m.
  static double apart_m(const recording::Trajectory& a, const recording::Trajectory& b) {
    EXPECT_EQ(a.size(), b.size());
    double worst = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
      worst = std::max(
          worst, (a[i].world_from_camera.translation - b[i].world_from_camera.translation).norm());
    }
    return worst;
  }

  roomwise::testing::ScratchFolder folder_;
  MapSettings settings_;
  SilentProgress silent_;
};

TEST_F(Culling, AWalkThatShowsTheSameAgainGoesWhenTheNextIsMapped) {
  const auto file = home_of_two("a.home");
  const std::size_t of_two = home::Home::open_read_only(file)->keyframes()->size();
  const auto third = map(file, 2);
  ASSERT_OK(third);
  EXPECT_GT(third->culled, 5U);
  const home::Home home = *home::Home::open_read_only(file);
  EXPECT_EQ(home.keyframes()->size(), of_two + third->keyframes - third->culled);
  EXPECT_EQ(third->components, 1U);
  EXPECT_EQ(stored_trajectory(home)->size(), 3U * kFrames) << "every frame keeps its place";
  ASSERT_OK(home.verify());
  const auto keyframes = home.keyframes().value();
  for (std::size_t i = 0; i < keyframes.size(); ++i) EXPECT_EQ(keyframes[i].id, i);
  for (home::RecordingId one = 1; one <= 3; ++one) {
    EXPECT_NE(std::ranges::find(keyframes, one, &home::Keyframe::recording), keyframes.end())
        << "by its first key-frame a recording is known again";
  }
  SyntheticWalk again = walk(1);
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  home::Home open = *home::Home::open(file);
  EXPECT_ERROR(map_recording(again, {again.info().name, "made up", again.info().camera, kFrames},
                             open, {}, settings_, run),
               "holds this recording already");
}

TEST_F(Culling, StoppedWhileItJudgesItEndsAsIfNeverStopped) {
  const auto whole = home_of_two("whole.home");
  for (const char* work : {"judging key-frames", "fusing the map", "adjusting landmarks"}) {
    const auto file = folder_ / fmt::format("{}.home", work);
    std::filesystem::copy(whole, file);
    testing::InterruptedAt interrupt(work);
    const auto stopped = map(file, 2, &interrupt);
    ASSERT_FALSE(stopped && stopped->finished) << work;
    ASSERT_OK(map(file, 2));
  }
  ASSERT_OK(map(whole, 2));
  for (const char* work : {"judging key-frames", "fusing the map", "adjusting landmarks"})
    EXPECT_EQ(digest(folder_ / fmt::format("{}.home", work)), digest(whole)) << work;
}

TEST_F(Culling, MovesNoFrameAndLosesNoJoin) {
  const auto file = home_of_two("a.home");
  {
    home::Home home = *home::Home::open(file);
    const auto before = stored_trajectory(home);
    const auto redundant = redundant_of(judge(home, 2));
    ASSERT_GT(redundant.size(), 5U);
    ASSERT_OK(cull_keyframes(home, redundant, settings_));
    const auto after = stored_trajectory(home);
    EXPECT_LT(apart_m(*before, *after), 0.005) << "but for what smoothing makes of it";
    const auto index = take_localizer_index(home);
    ASSERT_OK(index);
    EXPECT_TRUE(index->has_value()) << "the localiser needs no new one";
  }
  const auto further = map(file, 2);
  ASSERT_OK(further);
  EXPECT_TRUE(further->is_joined);
  EXPECT_EQ(further->components, 1U);
  EXPECT_EQ(stored_trajectory(*home::Home::open_read_only(file))->size(), 3U * kFrames);
}

TEST_F(Culling, TheFirstWalkIsJudgedByNone) {
  const auto file = home_of_two("a.home");
  const home::Home home = *home::Home::open_read_only(file);
  for (const auto& [id, verdict] : judge(home, 1)) EXPECT_NE(verdict, CullingVerdict::kAddsNothing);
}

TEST_F(Culling, AWalkThatIsTakenAwayCoversNothing) {
  const auto file = home_of_two("a.home");
  home::Home home = *home::Home::open(file);
  const auto redundant = redundant_of(judge(home, 2));
  ASSERT_GT(redundant.size(), 5U);
  const auto taken = take_walk_away(home, {"me", 1'700'000'000}, 1);
  ASSERT_OK(taken);
  EXPECT_TRUE(redundant_of(judge(home, 2)).empty()) << "erasing walk 1 would lose the place";
  ASSERT_OK(undo_edit(home, *taken));
  EXPECT_EQ(redundant_of(judge(home, 2)), redundant);
}

TEST_F(Culling, WhatSomethingHangsOnStays) {
  const auto file = home_of_two("a.home");
  home::Home home = *home::Home::open(file);
  const auto redundant = redundant_of(judge(home, 2));
  ASSERT_GT(redundant.size(), 3U);
  home::Edit note;
  note.made_by = "me";
  note.what = "note";
  note.change = R"({"note": "hot"})";
  note.before = "{}";
  home::EditPlace place;
  place.name = "stove";
  place.keyframe = redundant[1];
  place.box_keyframe.size_m = {0.5, 0.5, 0.5};
  note.places = {place};
  ASSERT_OK(home.add_edit(note));
  EXPECT_EQ(judge(home, 2).at(redundant[1]), CullingVerdict::kReferenced);
  EXPECT_ERROR(cull_keyframes(home, redundant, settings_), "something hangs on it");
  ASSERT_OK(cull_keyframes(home, {redundant[0], redundant[2]}, settings_));
  const auto edits = home.edits().value();
  EXPECT_EQ(edits.front().places.front().keyframe, redundant[1] - 1)
      << "it hangs on the same one, which has another number";
}

TEST_F(Culling, PicturesOfANamedRoomGiveWayToThoseOfTheSameRoomOnly) {
  const auto file = home_of_two("a.home");
  home::Home home = *home::Home::open(file);
  const auto redundant = redundant_of(judge(home, 2));
  ASSERT_GT(redundant.size(), 3U);
  ASSERT_OK(home.replace_rooms(std::vector<rooms::Room>{{"bath", "bathroom"}, {"hall", "hall"}}));
  ASSERT_OK(home.replace_room_ranges(2, {{0, kFrames - 1, "bath", 1}}));
  EXPECT_TRUE(redundant_of(judge(home, 2)).empty());
  ASSERT_OK(home.replace_room_ranges(1, {{0, kFrames - 1, "hall", 1}}));
  EXPECT_TRUE(redundant_of(judge(home, 2)).empty());
  ASSERT_OK(home.replace_room_ranges(1, {{0, kFrames - 1, "bath", 1}}));
  EXPECT_EQ(redundant_of(judge(home, 2)), redundant);
}

TEST_F(Culling, AWalkHasSeenARoomWhereItsPicturesAreCulled) {
  const auto file = home_of_two("a.home");
  home::Home home = *home::Home::open(file);
  const auto redundant = redundant_of(judge(home, 2));
  ASSERT_FALSE(redundant.empty());
  const std::uint64_t frame = home.keyframes().value()[redundant.front()].frame_index;
  ASSERT_OK(home.replace_rooms(std::vector<rooms::Room>{{"bath", "bathroom"}}));
  ASSERT_OK(home.replace_room_ranges(1, {{0, kFrames - 1, "bath", 1}}));
  ASSERT_OK(home.replace_room_ranges(2, {{frame, frame, "bath", 1}}));
  ASSERT_OK(cull_keyframes(home, redundant, settings_));
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  const auto coverage = find_room_coverage(home, {}, run);
  ASSERT_OK(coverage);
  ASSERT_EQ(coverage->rooms.size(), 1U);
  const RoomSeen& bath = coverage->rooms.front();
  ASSERT_EQ(bath.walks.size(), 2U);
  EXPECT_EQ(bath.walks[1].walk, 2);
  EXPECT_EQ(bath.walks[1].pictures, 0U);
  EXPECT_EQ(bath.by_several_lights(), false) << "it was culled for it showed the same";
  for (const CoverageItem& item : missing_items(*coverage, {}))
    EXPECT_NE(item.what, Missing::kSecondWalk) << "it was made";
}

TEST(CullingOptions, SaysWhichIsWrong) {
  EXPECT_OK(CullingOptions{}.validate());
  EXPECT_ERROR(CullingOptions{.covers = 0}.validate(), "covers = 0");
}

}  // namespace
}  // namespace roomwise::pipeline
