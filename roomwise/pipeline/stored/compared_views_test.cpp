#include "roomwise/pipeline/stored/compared_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

class ComparedViewsTest : public testing::MappedRoom {
 protected:
  // Where both are in truth.
  static motion::ViewAgreement agreement(ComparedViews& views, home::KeyframeId reference,
                                         home::KeyframeId current) {
    return views.compare(reference, current,
                         truth_from_camera(reference).inverse() * truth_from_camera(current));
  }
};

TEST_F(ComparedViewsTest, SayWhetherTwoKeyframesShowTheSamePlace) {
  auto views = ComparedViews::of(*home_);
  ASSERT_OK(views);
  const motion::ViewAgreement both = agreement(*views, 3, 4);
  EXPECT_GT(both.overlap, 0.2);
  EXPECT_GT(both.agreeing, 0.9);
  EXPECT_THAT(views->unread(), IsEmpty());
}

TEST_F(ComparedViewsTest, OneThatCannotBeReadOverlapsWithNoneAndIsToldOnce) {
  ASSERT_OK(
      home_->database().run("UPDATE keyframe_images SET depth = x'00' WHERE keyframe_id = 3"));
  auto views = ComparedViews::of(*home_);
  ASSERT_OK(views);
  EXPECT_EQ(agreement(*views, 3, 4).overlap, 0);
  EXPECT_EQ(agreement(*views, 2, 3).overlap, 0);
  EXPECT_GT(agreement(*views, 4, 5).overlap, 0.2);
  EXPECT_THAT(views->unread(), ElementsAre(Pair(3, HasSubstr("a.home: key-frame 3: "))));
}

}  // namespace
}  // namespace roomwise::pipeline
