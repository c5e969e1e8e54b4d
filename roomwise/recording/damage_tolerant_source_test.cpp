#include "roomwise/recording/damage_tolerant_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Three frames.
class DamagedRecording : public ::testing::Test {
 protected:
  DamagedRecording() {
    write("camera.txt", "7 7 4 3 8 6 1000\n");
    write("rgb.txt", "0.0 0.png\n0.1 1.png\n0.2 2.png\n");
    write("depth.txt", "0.0 d.png\n0.1 d.png\n0.2 d.png\n");
    for (int i = 0; i < 3; ++i) {
      write(fmt::format("{}.png", i), image::encode_png(image::ColorImage(8, 6)));
    }
    write("d.png", image::encode_png(image::DepthImage(8, 6, 1500)));
  }
  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    EXPECT_OK(write_file(folder_ / name, content));
  }

  roomwise::testing::ScratchFolder folder_;
};

TEST_F(DamagedRecording, IsReadWithoutTheFramesThatCannotBeRead) {
  write("1.png", std::string_view("no picture"));
  const auto recording = open_recording(folder_.path()).value();
  DamageTolerantSource frames(*recording, true);
  EXPECT_EQ(frames.next().value()->index, 0U);
  EXPECT_EQ(frames.next().value()->index, 2U) << "a gap, so that labels by number stay true";
  EXPECT_FALSE(frames.next().value().has_value());
  EXPECT_THAT(frames.damage(), ElementsAre(HasSubstr("1.png")));
}

TEST_F(DamagedRecording, EndsAtTheFirstSuchFrameWhereNoneIsToBeLeftOut) {
  write("1.png", std::string_view("no picture"));
  const auto recording = open_recording(folder_.path()).value();
  DamageTolerantSource frames(*recording, false);
  EXPECT_OK(frames.next());
  EXPECT_FALSE(frames.is_stopped());
  EXPECT_ERROR(frames.next(), "1.png");
  EXPECT_TRUE(frames.is_stopped()) << "so that who asks is told how to go on";
}

TEST_F(DamagedRecording, IsNoneWhereNothingCanBeRead) {
  write("d.png", std::string_view("no picture"));
  const auto recording = open_recording(folder_.path()).value();
  DamageTolerantSource frames(*recording, true);
  EXPECT_ERROR(frames.next(), "none of its 3 frames can be read; the first: ");
}

}  // namespace
}  // namespace roomwise::recording
