#include <gmock/gmock.h>
#include <sys/stat.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/phone/record3d.h"
#include "roomwise/recording/phone/testing/record3d_writer.h"
#include "roomwise/recording/phone/zip_unpack.h"
#include "roomwise/recording/robot/testing/robot_log.h"
#include "roomwise/recording/sens/testing/sens_writer.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;

// Whatever the file is called.
TEST(KindsOfFiles, AreToldByTheirContent) {
  const roomwise::testing::ScratchFolder folder;
  const auto kind_of = [&](const Bytes& bytes) {
    EXPECT_OK(write_file(folder / "walk", bytes));
    const auto recording = open_recording(folder / "walk");
    return recording ? (*recording)->kind() : recording.error().message;
  };
  EXPECT_EQ(kind_of(BagWriter::write(simple_robot().plan())), "ROS 1 bag");
  EXPECT_EQ(kind_of(McapWriter::write(simple_robot(Encoding::kCdr).plan())), "MCAP");
  EXPECT_EQ(kind_of(sens_file({})), "ScanNet .sens");
  ASSERT_TRUE(write_zip(folder / "zip", phone_files()));
  EXPECT_EQ(kind_of(read_file(folder / "zip").value()), "Record3D .r3d");
  EXPECT_THAT(kind_of({4, 0, 0, 0}),
              ::testing::HasSubstr("is no recording of a kind that is read"));
  EXPECT_THAT(kind_of({}), ::testing::HasSubstr("is no recording of a kind that is read"));
}

// Nobody writes it, so that whoever opened it to read would wait.
TEST(KindsOfFiles, APipeIsNone) {
  const roomwise::testing::ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "walk.r3d").c_str(), 0600), 0);
  EXPECT_ERROR(open_recording(folder / "walk.r3d"), "is no recording of a kind that is read");
  EXPECT_ERROR(open_record3d(folder / "walk.r3d", {}), "is no regular file");
  EXPECT_FALSE(is_zip_file(folder / "walk.r3d"));
}

}  // namespace
}  // namespace roomwise::recording
