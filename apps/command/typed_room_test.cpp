#include "typed_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace roomwise::app {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::array<int, 2> new_pipe() {
  std::array<int, 2> ends{-1, -1};
  EXPECT_EQ(::pipe(ends.data()), 0);
  return ends;
}

// Somebody who types, and what they read.
class TypedRoomTest : public ::testing::Test {
 protected:
  ~TypedRoomTest() override {
    ::close(pipe_[0]);
    if (pipe_[1] >= 0) ::close(pipe_[1]);
  }
  bool take_typed(const std::string& typed) {
    EXPECT_EQ(::write(pipe_[1], typed.data(), typed.size()), static_cast<ssize_t>(typed.size()));
    return typed_.take(room_, progress_);
  }
  void leave() { ::close(std::exchange(pipe_[1], -1)); }

  std::string said_;
  std::optional<std::string> room_;
  std::array<int, 2> pipe_ = new_pipe();
  TerminalProgress progress_{
      {[this](std::string_view text) { said_ += text; }}, [] { return TimeLeft::Time(); }, {}};
  TypedRoom typed_{pipe_[0]};
};

TEST_F(TypedRoomTest, TheLastLineCountsAndEnterAloneIsNoRoom) {
  EXPECT_FALSE(take_typed("ba"));
  EXPECT_EQ(room_, std::nullopt);
  EXPECT_TRUE(take_typed("th\nkitchen\n"));
  EXPECT_EQ(room_, "kitchen");
  EXPECT_TRUE(take_typed(" \n"));
  EXPECT_EQ(room_, std::nullopt);
}

TEST_F(TypedRoomTest, BlanksTooManyDoNoHarm) {
  EXPECT_TRUE(take_typed("  living \t room  \n"));
  EXPECT_EQ(room_, "living room");
  EXPECT_THAT(said_, IsEmpty());
}

TEST_F(TypedRoomTest, WhatIsNoNameIsSaidAndTheRoomStays) {
  EXPECT_TRUE(take_typed("kitchen\n"));
  EXPECT_FALSE(take_typed("bedroom #2\n"));
  EXPECT_EQ(room_, "kitchen");
  EXPECT_THAT(said_, HasSubstr("note: 'bedroom #2' is no name for a room"));
  EXPECT_THAT(said_, HasSubstr("the room stays as it was"));
}

TEST_F(TypedRoomTest, NothingIsReadOfWhoLeftOrIsNotThere) {
  TypedRoom nobody(-1);
  EXPECT_FALSE(nobody.take(room_, progress_));
  EXPECT_TRUE(take_typed("bath\nkit"));
  leave();
  EXPECT_FALSE(typed_.take(room_, progress_));
  EXPECT_EQ(room_, "bath");
}

}  // namespace
}  // namespace roomwise::app
