#include "roomwise/recording/read_ahead_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::recording {
namespace {

// Twelve frames, more than are read ahead, of which one is damaged.
class ReadAhead : public ::testing::Test {
 protected:
  static constexpr int kCount = 12, kDamaged = 5;

  ReadAhead() {
    std::string colors, depths;
    for (int i = 0; i < kCount; ++i) {
      colors += fmt::format("0.{:02} {}.png\n", i, i);
      depths += fmt::format("0.{:02} d.png\n", i);
      const image::ColorImage color(8, 6, {static_cast<std::uint8_t>(i), 0, 0});
      write(fmt::format("{}.png", i), image::encode_png(color));
    }
    write("camera.txt", "7 7 4 3 8 6 1000\n");
    write("rgb.txt", colors);
    write("depth.txt", depths);
    write("d.png", image::encode_png(image::DepthImage(8, 6, 1500)));
    write(fmt::format("{}.png", kDamaged), std::string_view("no picture"));
    recording_ = open_recording(folder_.path()).value();
  }
  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    EXPECT_OK(write_file(folder_ / name, content));
  }
  static image::RgbdFrame prepared(image::RgbdFrame frame) {
    frame.color.at(0, 0).g = 99;
    return frame;
  }

  roomwise::testing::ScratchFolder folder_;
  std::unique_ptr<Recording> recording_;
  ThreadPool pool_{3};
};

TEST_F(ReadAhead, GivesFramesAndErrorsInTheirOrder) {
  ReadAheadSource ahead(*recording_, pool_, &prepared);
  EXPECT_EQ(ahead.info().frames_remaining, std::uint64_t{kCount});
  for (int i = 0; i < kCount; ++i) {
    const auto frame = ahead.next();
    EXPECT_EQ(ahead.info().frames_remaining, static_cast<std::uint64_t>(kCount - i - 1));
    if (i == kDamaged) {
      EXPECT_ERROR(frame, "5.png");
      continue;
    }
    ASSERT_OK(frame);
    EXPECT_EQ((*frame)->index, static_cast<std::uint64_t>(i));
    EXPECT_EQ((*frame)->color.at(0, 0).r, i);
    EXPECT_EQ((*frame)->color.at(0, 0).g, 99) << "prepared";
  }
  EXPECT_FALSE(ahead.next().value().has_value());
  EXPECT_FALSE(ahead.next().value().has_value());
}

TEST_F(ReadAhead, PassesOverFrames) {
  ReadAheadSource ahead(*recording_, pool_, &prepared);
  ASSERT_OK(ahead.next());
  ahead.skip_before(3);  // some of these were read already
  EXPECT_EQ(ahead.next().value()->index, 3U);
  ahead.skip_before(10);
  EXPECT_EQ(ahead.next().value()->index, 10U);
  EXPECT_EQ(ahead.info().frames_remaining, 1U);
}

TEST_F(ReadAhead, EndsWhileFramesAreBeingRead) {
  ReadAheadSource ahead(*recording_, pool_, &prepared);
  EXPECT_EQ(ahead.next().value()->index, 0U);
}

}  // namespace
}  // namespace roomwise::recording
