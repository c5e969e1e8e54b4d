#include "roomwise/recording/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;

class TrajectoryFile : public ::testing::Test {
 protected:
  Expected<Trajectory> read(std::string_view text) {
    EXPECT_OK(write_file(path_, text));
    return read_trajectory(path_);
  }
  [[nodiscard]] std::string line(int number) const {
    return fmt::format("{}:{}", path_.string(), number);
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "poses.txt";
};

TEST_F(TrajectoryFile, ReadsPosesAndNormalisesTheirRotation) {
  const auto trajectory = read(
      "# timestamp tx ty tz qx qy qz qw\r\n\n1305031229.5 1 -2  3.5 0 0 2 0 \r\n1305031230 0 0 0 0 "
      "0 0 1");
  ASSERT_OK(trajectory);
  ASSERT_EQ(trajectory->size(), 2U);
  const auto& [timestamp_ns, pose] = trajectory->front();
  EXPECT_EQ(timestamp_ns, 1305031229500000000);
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1, -2, 3.5));
  EXPECT_EQ(pose.rotation.coeffs(), Eigen::Vector4d(0, 0, 1, 0));
}

TEST_F(TrajectoryFile, GivesBackWhatWasWritten) {
  Trajectory written;
  for (int i = 0; i < 20; ++i) {
    geometry::Vector6d twist;
    twist << 0.1 * i, -0.2 * i, 0.05 * i, i, -0.5 * i, 0.001 * i;
    written.push_back({i * 33'333'333, geometry::RigidTransform::exp(twist)});
  }
  ASSERT_OK(write_trajectory(path_, written));
  const auto read_back = read_trajectory(path_);
  ASSERT_OK(read_back);
  ASSERT_EQ(read_back->size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    const auto difference =
        written[i].world_from_camera.inverse() * (*read_back)[i].world_from_camera;
    EXPECT_EQ((*read_back)[i].timestamp_ns, written[i].timestamp_ns);
    EXPECT_LT(difference.distance_m(), 1e-8);
    EXPECT_LT(difference.angle_rad(), 1e-8);
  }
}

TEST_F(TrajectoryFile, NamesTheLineThatIsWrong) {
  EXPECT_ERROR(read_trajectory(folder_ / "none.txt"), "none.txt");
  EXPECT_ERROR(read("# nothing\n"), "holds no pose");
  EXPECT_ERROR(read("1 0 0 0 0 0 0 1\n\n2 0 0 0 0 0 0\n"), line(3) + ": 7 values");
  EXPECT_ERROR(read("1 0 0 0 0 0 0 1 5\n"), "9 values");
  EXPECT_ERROR(read("now 0 0 0 0 0 0 1\n"), line(1) + ": 'now' is not a time stamp");
  EXPECT_ERROR(read("1 0 nan 0 0 0 0 1\n"), line(1) + ": ty = 'nan'");
  EXPECT_ERROR(read("1 0 0 0 0 inf 0 1\n"), "qy = 'inf'");
  EXPECT_ERROR(read("1 0 0 0 0 0 0 0\n"), "no usable length");
  EXPECT_ERROR(read("1 0 0 0 0 0 0 1e300\n2 0 0 0 1e300 1e300 0 1\n"), "no usable length");
  EXPECT_ERROR(read("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"),
               line(2) + ": the time 1 does not increase");
  EXPECT_ERROR(read("1 0 0 0 0 0 0 1\n1.0 0 0 0 0 0 0 1\n"), "does not increase");
}

TEST_F(TrajectoryFile, ReadsRealGroundTruth) {
  for (const char* name : {"rgbd_dataset_freiburg1_rpy", "office_walk", "tum_fr1_desk_9frames"}) {
    const auto recording = roomwise::testing::find_data(name);
    ROOMWISE_REQUIRE_FILE(recording);
    EXPECT_OK(read_trajectory(*recording / "groundtruth.txt"));
  }
}

}  // namespace
}  // namespace roomwise::recording
