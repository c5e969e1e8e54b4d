#include "roomwise/pipeline/report/home_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using HomeReportTest = testing::MappedRoom;

TEST_F(HomeReportTest, CountsNothingOfAWalkThatIsTakenAway) {
  ASSERT_OK(home_->replace_rooms(std::vector<rooms::Room>{{"hall", "hall"}}));
  ASSERT_OK(home_->replace_room_ranges(1, {{0, kKeyframes - 1, "hall", 1}}));
  const auto summary = [](const evaluation::ReportContent& content) {
    std::vector<std::string> lines;
    for (const auto& figure : content.summary) lines.push_back(figure.name + ": " + figure.value);
    return lines;
  };
  const auto alone = report_content(*home_, {}, run_);
  ASSERT_OK(alone);

  // Key-frames on the map, and two that could not be joined to it.
  const auto walk = home_->add_recording({"later", "", fusion::testing::small_camera(), 4});
  ASSERT_OK(walk);
  home::MapCommit step{
      .recording = *walk, .keyframes = {}, .edges = {}, .frames = {}, .next_frame_index = 4};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto like = home_->keyframes()->at(i);
    const home::KeyframeId id = kKeyframes + i;
    step.keyframes.push_back({{id, i, like.timestamp_ns},
                              {like.pose.world_from_keyframe, i < 2 ? 0U : 1U},
                              home_->images(i).value(),
                              {},
                              {}});
    scene::PoseGraphEdge edge;
    edge.from = i;
    edge.to = id;
    edge.is_robust = true;
    step.edges.push_back(edge);
    step.frames.push_back({i, like.timestamp_ns, home::FramePlace{id, {}}, ""});
  }
  ASSERT_OK(home_->commit(step));
  ASSERT_OK(home_->finish_recording(*walk));
  ASSERT_OK(home_->replace_room_ranges(*walk, {{0, 3, "hall", 1}}));
  ASSERT_OK(take_walk_away(*home_, {"Anna", 1}, *walk));

  const auto now = report_content(*home_, {}, run_);
  ASSERT_OK(now);
  EXPECT_EQ(summary(*now), summary(*alone));
  EXPECT_EQ(now->rooms.front().key_frames, kKeyframes);
  EXPECT_EQ(now->key_frames.size(), kKeyframes);
  EXPECT_EQ(now->warnings, alone->warnings);
}

}  // namespace
}  // namespace roomwise::pipeline
