#include "roomwise/recording/openni2_source.h"

#include <OpenNI.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "roomwise/base/testing/testing.h"

// OpenNI 2 itself loads the made-up camera of testing/fake_openni2_driver.cpp, and its own driver
// of .oni files, from a folder of the build (CMakeLists.txt): what runs here is the way of a real
// camera's frames from OpenNI on.

// What sanitizers must not report, since it is OpenNI's: it leaks a little at each start, out of
// code that is unloaded by the time of the report, so that no suppression could name it; and it
// unlocks mutexes that nobody locked.
extern "C" const char* __asan_default_options() {
  return "detect_leaks=0";
}
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libOpenNI2.so\nmutex:libOniFile.so\n"
         "deadlock:libOpenNI2.so\ndeadlock:libOniFile.so\n";
}

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;

OpenNi2Options device(std::string uri) {
  OpenNi2Options options;
  options.uri = std::move(uri);
  return options;
}

// The numbers of the made-up camera's pictures (colour's modulo 256), which must be whole.
struct FakeNumbers {
  int color;
  int depth;
};
FakeNumbers numbers_of(const image::RgbdFrame& frame) {
  EXPECT_EQ(frame.color.width(), 640);
  EXPECT_EQ(frame.color.height(), 480);
  EXPECT_EQ(frame.depth.width(), 640);
  EXPECT_EQ(frame.depth.height(), 480);
  const FakeNumbers numbers{frame.color.at(0, 0).r, frame.depth.at(0, 0) - 1000};
  EXPECT_EQ(frame.color.at(639, 200), (Rgb8{static_cast<std::uint8_t>(numbers.color), 127, 200}));
  EXPECT_EQ(frame.depth.at(639, 479), 1000 + numbers.depth);
  return numbers;
}

TEST(OpenNi2Source, GivesTheFramesOfACamera) {
  auto source = OpenNi2Source::open(device(""));
  ASSERT_OK(source);
  EXPECT_THAT((*source)->info().name, ::testing::HasSubstr("Fake camera"));
  EXPECT_FALSE((*source)->info().frames_remaining.has_value());
  TimestampNs last_ns = -1;
  for (std::uint64_t i = 0; i < 10; ++i) {
    auto frame = (*source)->next();
    ASSERT_OK(frame);
    ASSERT_TRUE(frame->has_value());
    EXPECT_EQ((*frame)->index, i);
    EXPECT_GT((*frame)->timestamp_ns, last_ns);
    last_ns = (*frame)->timestamp_ns;
    const FakeNumbers numbers = numbers_of(**frame);
    EXPECT_EQ(numbers.color, numbers.depth % 256) << "one moment";
    EXPECT_NEAR(static_cast<double>(last_ns) * kSecondsPerNs, numbers.depth / 30.0, 1e-5);
  }
}

TEST(OpenNi2Source, TakesTheCameraFromTheFieldOfView) {
  auto source = OpenNi2Source::open(device("fake:camera"));
  ASSERT_OK(source);
  const geometry::PinholeCamera& camera = (*source)->info().camera;
  EXPECT_OK(camera.validate());
  EXPECT_NEAR(camera.fx, 320 / std::tan(0.5), 1e-3);
  EXPECT_NEAR(camera.fy, 240 / std::tan(0.4), 1e-3);
  EXPECT_EQ(camera.cx, 319.5);
  EXPECT_EQ(camera.cy, 239.5);
  EXPECT_EQ(camera.depth_units_per_metre, 1000);
}

TEST(OpenNi2Source, TakesACalibrationInstead) {
  OpenNi2Options options = device("fake:camera");
  options.camera = geometry::camera_preset("fr1").value();
  auto source = OpenNi2Source::open(options);
  ASSERT_OK(source);
  EXPECT_EQ((*source)->info().camera.fx, 517.3);
  EXPECT_EQ((*source)->info().camera.depth_units_per_metre, 1000) << "the device knows its unit";

  source->reset();
  options.camera->width = 320;
  EXPECT_ERROR(OpenNi2Source::open(options), "320x480");
}

TEST(OpenNi2Source, SaysWhatIsWrongWithTheDevice) {
  EXPECT_ERROR(OpenNi2Source::open(device("nothing:here")), "nothing:here");
  EXPECT_ERROR(OpenNi2Source::open(device("fake:no-colour")), "has no colour stream");
  EXPECT_ERROR(OpenNi2Source::open(device("fake:no-registration")), "register");
  EXPECT_ERROR(OpenNi2Source::open(device("fake:small")), "640x480");
}

TEST(OpenNi2Source, SaysThatNoCameraIsThere) {
  ASSERT_EQ(setenv("ROOMWISE_FAKE_CAMERA_UNPLUGGED", "1", 1), 0);
  EXPECT_ERROR(OpenNi2Source::open(device("")), "finds no camera");
  unsetenv("ROOMWISE_FAKE_CAMERA_UNPLUGGED");
}

TEST(OpenNi2Source, WaitsForAFrameNoLongerThanAllowed) {
  OpenNi2Options options = device("fake:silent");
  options.timeout_s = 0.05;
  auto source = OpenNi2Source::open(options);
  ASSERT_OK(source);
  EXPECT_ERROR((*source)->next(), "gave no colour frame for 0.05 s");
}

// Records the made-up camera by OpenNI's own means.
void record_oni(const std::filesystem::path& path, int frames) {
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  {
    openni::Device camera;
    ASSERT_EQ(camera.open("fake:camera"), openni::STATUS_OK);
    openni::VideoStream color, depth;
    ASSERT_EQ(color.create(camera, openni::SENSOR_COLOR), openni::STATUS_OK);
    ASSERT_EQ(depth.create(camera, openni::SENSOR_DEPTH), openni::STATUS_OK);
    color.setMirroringEnabled(false);
    depth.setMirroringEnabled(false);
    openni::Recorder recorder;
    ASSERT_EQ(recorder.create(path.c_str()), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(color), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(depth), openni::STATUS_OK);
    ASSERT_EQ(recorder.start(), openni::STATUS_OK);
    ASSERT_EQ(color.start(), openni::STATUS_OK);
    ASSERT_EQ(depth.start(), openni::STATUS_OK);
    openni::VideoFrameRef frame;
    for (int i = 0; i < frames; ++i) {
      color.readFrame(&frame);
      depth.readFrame(&frame);
    }
    // In this order: a recorder that is stopped under running streams can deadlock inside OpenNI.
    color.stop();
    depth.stop();
    recorder.stop();
    recorder.destroy();
  }
  openni::OpenNI::shutdown();
}

TEST(OpenNi2Source, ReadsAnOniFileToItsEnd) {
  const ScratchFolder folder;
  const auto file = folder / "walk.oni";
  record_oni(file, 20);
  auto source = OpenNi2Source::open(device(file));
  ASSERT_OK(source);
  const auto promised = (*source)->info().frames_remaining;
  ASSERT_TRUE(promised.has_value());
  std::uint64_t frames = 0;
  std::optional<int> offset;
  for (;;) {
    auto frame = (*source)->next();
    ASSERT_OK(frame);
    if (!frame->has_value()) break;
    EXPECT_EQ((*frame)->index, frames++);
    // The recorder may miss a first frame, and lets both clocks begin at 0.
    const FakeNumbers numbers = numbers_of(**frame);
    if (!offset) offset = (numbers.color - numbers.depth) & 0xFF;
    EXPECT_EQ((numbers.color - numbers.depth) & 0xFF, *offset);
  }
  ASSERT_GT(frames, 0U);
  EXPECT_LE(frames, *promised);
  EXPECT_EQ((*source)->info().frames_remaining, 0U);
  EXPECT_FALSE((*source)->next()->has_value()) << "stays at the end";

  source->reset();
  source = OpenNi2Source::open(device(file));
  ASSERT_OK(source);
  (*source)->skip_before(frames - 1);
  auto last = (*source)->next();
  ASSERT_OK(last);
  ASSERT_TRUE(last->has_value());
  EXPECT_EQ((*last)->index, frames - 1);
  EXPECT_FALSE((*source)->next()->has_value());
}

TEST(OpenNi2Source, RefusesAFileThatIsNone) {
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "torn.oni", "NI10"));
  EXPECT_ERROR(OpenNi2Source::open(device(folder / "torn.oni")), "torn.oni");
}

}  // namespace
}  // namespace roomwise::recording
