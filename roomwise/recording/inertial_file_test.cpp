#include "roomwise/recording/inertial_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class InertialFile : public ::testing::Test {
 protected:
  geometry::InertialTrack read(std::string_view text, const char* file = "imu.txt") {
    EXPECT_OK(write_file(folder_ / file, text));
    notes_.clear();
    return read_inertial(folder_.path(), notes_);
  }

  roomwise::testing::ScratchFolder folder_;
  std::vector<std::string> notes_;
};

TEST_F(InertialFile, SamplesAreInTheCamerasFrame) {
  const auto track = read("# a phone\n1.5 0.1 0.2 0.3 0 -9.8 0.1\n1.505 0.1 0.2 0.4 0 -9.8 0.1\n");
  EXPECT_THAT(notes_, IsEmpty());
  ASSERT_THAT(track.samples(), SizeIs(2));
  EXPECT_TRUE(track.tells_turns());
  EXPECT_EQ(track.samples()[1].timestamp_ns, 1'505'000'000);
  EXPECT_EQ(track.samples()[1].turning_rad_s, Vector3d(0.1, 0.2, 0.4));
  EXPECT_EQ(track.samples()[0].force_m_s2, Vector3d(0, -9.8, 0.1));
}

TEST_F(InertialFile, ASensorMayBeTurnedToTheCamera) {
  // Its x is the camera's y.
  const auto track = read("# camera_from_imu 0 0 0.70710678 0.70710678\n0 0.5 0 0 -9.8 0 0\n");
  ASSERT_THAT(track.samples(), SizeIs(1));
  EXPECT_LT((track.samples()[0].turning_rad_s - Vector3d(0, 0.5, 0)).norm(), 1e-7);
  EXPECT_LT((track.samples()[0].force_m_s2 - Vector3d(0, -9.8, 0)).norm(), 1e-6);

  EXPECT_TRUE(read("# camera_from_imu 0 0 1\n0 0 0 0 9.8 0 0\n").empty());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("imu.txt: line 1: '0 0 1' is no rotation")));
}

TEST_F(InertialFile, AKinectsAccelerometerIsHalfATurnFromItsCamera) {
  const auto track = read("1305031225.727159 0.682514 7.818977 -5.603800\n", "accelerometer.txt");
  EXPECT_THAT(notes_, IsEmpty());
  EXPECT_FALSE(track.tells_turns());
  ASSERT_THAT(track.samples(), SizeIs(1));
  EXPECT_LT((track.samples()[0].force_m_s2 - Vector3d(-0.682514, -7.818977, -5.6038)).norm(), 1e-9)
      << "up is where the camera's y does not point";
}

TEST_F(InertialFile, WhatIsWrongInALineIsLeftOutAndSaid) {
  const auto track = read(
      "0 0 0 0 0 -9.8 0\n"
      "0.01 nan 0 0 0 -9.8 0\n"
      "0.02 0 0 0 0 -9.8\n"
      "0.03 0 0 0 0 -9.8 0\n"
      "0.02 0 0 0 0 -9.8 0\n"
      "0.04 0 0 0 0 -9.8 0\n"
      "0.05 0 0 0 0 -9");  // and cut off here
  EXPECT_THAT(track.samples(), SizeIs(3));
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("imu.txt: 3 samples of the inertial sensor are left "
                                            "out; the first: line 2: wx = 'nan'")));
}

TEST_F(InertialFile, ForcesInGAreToldByTheirLength) {
  const auto track = read("0 0 0 0 0 -1.01 0\n0.01 0 0 0 0 -0.99 0\n0.02 0 0 0 0 -1 0\n");
  ASSERT_THAT(track.samples(), SizeIs(3));
  EXPECT_NEAR(track.samples()[2].force_m_s2.y(), -9.80665, 1e-9);
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("taken for g")));
}

TEST_F(InertialFile, UnitsThatCannotBeAreLeftOut) {
  EXPECT_TRUE(read("0 0 0 0 0 -1000 0\n").empty());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("the inertial sensor is left out")));
  EXPECT_TRUE(read("0 0 0 0 0 0.1 0\n").empty()) << "gravity was taken out";
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("with gravity")));

  const auto in_degrees = read("0 0 0 90 0 -9.8 0\n");
  EXPECT_FALSE(in_degrees.empty());
  EXPECT_FALSE(in_degrees.tells_turns());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("degrees")));
}

TEST_F(InertialFile, ForcesOfTheOtherSignAreLeftOutAndACameraOnItsSideIsNot) {
  EXPECT_TRUE(read("0 0 0 0 0 9.8 1\n0.01 0 0 0 1 9.8 0\n").empty());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("turn their sign")));
  for (const char* force : {"9.8 0 0", "-9.8 1 0", "0 2 9.6", "0 -3 -9.4"}) {
    EXPECT_FALSE(read(std::string("0 0 0 0 ") + force + "\n").empty()) << force;
    EXPECT_THAT(notes_, IsEmpty()) << force;
  }
}

TEST_F(InertialFile, ThereMayBeNone) {
  EXPECT_TRUE(read_inertial(folder_.path(), notes_).empty());
  EXPECT_THAT(notes_, IsEmpty());
  EXPECT_TRUE(read("# nothing yet\n").empty());
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("holds no sample")));
}

TEST_F(InertialFile, IsReadAsItWasWritten) {
  for (const bool tells_turns : {true, false}) {
    const roomwise::testing::ScratchFolder folder;
    std::vector<geometry::InertialSample> samples{{1'000'000'000, {0.125, 0, -2}, {0.5, -9.75, 1}},
                                                  {1'005'000'000, {0.25, 0, -2}, {0.5, -9.5, 1}}};
    if (!tells_turns)
      for (auto& one : samples) one.turning_rad_s.setZero();
    ASSERT_OK(write_inertial(folder.path(), {samples, tells_turns}, "a test"));
    const auto read = read_inertial(folder.path(), notes_);
    EXPECT_THAT(notes_, IsEmpty());
    EXPECT_EQ(read.tells_turns(), tells_turns);
    ASSERT_EQ(read.samples().size(), samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_EQ(read.samples()[i].timestamp_ns, samples[i].timestamp_ns);
      EXPECT_EQ(read.samples()[i].turning_rad_s, samples[i].turning_rad_s);
      EXPECT_EQ(read.samples()[i].force_m_s2, samples[i].force_m_s2);
    }
  }
}

}  // namespace
}  // namespace roomwise::recording
