#include "roomwise/recording/messages/message_log.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/bytes/testing/quick_file.h"
#include "roomwise/recording/messages/mcap_file.h"
#include "roomwise/recording/messages/messages.h"
#include "roomwise/recording/messages/ros1_bag.h"
#include "roomwise/recording/messages/testing/log_writers.h"
#include "roomwise/recording/messages/testing/message_writer.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr TimestampNs kSecond = 1'000'000'000;

enum class FileKind { kMcap, kBag };

Channel channel(const std::string& topic, const std::string& type, Encoding encoding) {
  return {topic, type, message_type_named(type), encoding};
}

// Odometry, whose header says when, and a scan, which is not read. What a robot says at 3.5 s is
// recorded first.
LogPlan small_plan(FileKind kind) {
  const Encoding encoding = kind == FileKind::kBag ? Encoding::kRos1 : Encoding::kCdr;
  const auto odometry = [&](TimestampNs time) {
    return write_odometry(encoding, {{time, "odom"}, "base", {}});
  };
  LogPlan plan;
  plan.channels = {channel("/odom", "nav_msgs/Odometry", encoding),
                   channel("/scan", "sensor_msgs/LaserScan", encoding)};
  plan.chunks = {{{0, 4 * kSecond, odometry(7 * kSecond / 2)}, {1, 4 * kSecond, Bytes(40, 1)}},
                 {{0, 5 * kSecond, odometry(3 * kSecond)}},
                 {{1, 6 * kSecond, Bytes(40, 2)}}};
  return plan;
}

class LogTest : public ::testing::TestWithParam<FileKind> {
 protected:
  Bytes written(const LogPlan& plan) const {
    return GetParam() == FileKind::kBag ? BagWriter::write(plan) : McapWriter::write(plan);
  }
  Expected<MessageLog> read_bytes(std::span<const std::uint8_t> bytes) const {
    const auto path = folder_ / "log";
    write_quickly(path, bytes);
    return GetParam() == FileKind::kBag ? read_ros1_bag(path) : read_mcap(path);
  }
  Expected<MessageLog> read(const LogPlan& plan) const { return read_bytes(written(plan)); }
  const LogPlan plan_ = small_plan(GetParam());

 private:
  roomwise::testing::ScratchFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Files, LogTest, ::testing::Values(FileKind::kMcap, FileKind::kBag),
                         [](const auto& tested) {
                           return tested.param == FileKind::kMcap ? "Mcap" : "Bag";
                         });

std::vector<TimestampNs> times_of(const MessageLog& log, std::size_t channel) {
  std::vector<TimestampNs> times;
  for (const MessagePlace& message : log.messages(channel)) times.push_back(message.timestamp_ns);
  return times;
}

void expect_whole(const Expected<MessageLog>& log, const LogPlan& plan) {
  ASSERT_OK(log);
  ASSERT_THAT(log->channels(), SizeIs(2));
  EXPECT_EQ(log->channels()[0].topic, "/odom");
  EXPECT_EQ(log->channels()[0].type, MessageType::kOdometry);
  EXPECT_FALSE(log->channels()[1].is_read());
  EXPECT_THAT(log->notes(), IsEmpty());
  EXPECT_THAT(times_of(*log, 0), ElementsAre(3 * kSecond, 7 * kSecond / 2));
  EXPECT_THAT(log->messages(1), IsEmpty());
  EXPECT_EQ(log->messages(0)[1].logged_ns, 4 * kSecond);
  EXPECT_EQ(log->read(log->messages(0)[0]).value(), plan.chunks[1][0].data);
  EXPECT_EQ(log->read(log->messages(0)[1]).value(), plan.chunks[0][0].data);
}

TEST_P(LogTest, GivesMessagesByTheTimeOfTheirHeaders) {
  expect_whole(read(plan_), plan_);
}

TEST_P(LogTest, ReadsChunksOfEachPacking) {
  LogPlan plan = plan_;
  for (const char* packing : {"lz4", GetParam() == FileKind::kBag ? "bz2" : "zstd"}) {
    plan.packing = packing;
    expect_whole(read(plan), plan);
  }
}

TEST_P(LogTest, ReadsAFileWithoutAnIndex) {
  LogPlan plan = plan_;
  plan.has_index = false;
  expect_whole(read(plan), plan);
}

TEST_P(LogTest, PassesOverChunksThatHoldNothingThatIsRead) {
  Bytes bytes = written(plan_);
  // The third chunk's message is spoilt, which nobody sees.
  const auto spoilt = std::ranges::search(bytes, Bytes(40, 2));
  std::ranges::fill(spoilt, std::uint8_t{3});
  expect_whole(read_bytes(bytes), plan_);
}

TEST_P(LogTest, GivesAnErrorOrWhatComesBeforeWhereItIsCutOff) {
  for (const char* packing : {"", "lz4"}) {
    LogPlan plan = plan_;
    plan.packing = packing;
    const Bytes whole = written(plan);
    std::size_t most = 0;
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto log = read_bytes(std::span(whole).first(size));
      if (!log) {
        EXPECT_THAT(log.error().message, HasSubstr("log"));
        continue;
      }
      std::size_t count = 0;
      for (std::size_t i = 0; i < log->channels().size(); ++i) {
        for (const MessagePlace& message : log->messages(i)) EXPECT_OK(log->read(message));
        count += log->messages(i).size();
      }
      EXPECT_GE(count, most) << "cut off at byte " << size;
      most = std::max(most, count);
    }
    EXPECT_EQ(most, 2U);
  }
}

TEST_P(LogTest, SaysThatTheEndIsMissing) {
  LogPlan plan = plan_;
  plan.has_index = false;
  Bytes bytes = written(plan);
  const auto last = std::ranges::search(bytes, Bytes(40, 2));
  bytes.erase(last.begin(), bytes.end());
  const auto log = read_bytes(bytes);
  ASSERT_OK(log);
  EXPECT_THAT(log->notes(), ElementsAre(HasSubstr("ends within a record")));
  EXPECT_THAT(log->messages(0), SizeIs(2));
}

TEST_P(LogTest, RefusesAnUnknownPacking) {
  LogPlan plan = plan_;
  plan.packing = "br";
  EXPECT_ERROR(read(plan), "compressed by 'br'");
}

TEST_P(LogTest, SurvivesEveryFlippedBit) {
  LogPlan plan = plan_;
  plan.packing = "lz4";
  const Bytes whole = written(plan);
  for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 3) {
    Bytes bytes = whole;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    const auto log = read_bytes(bytes);
    if (!log) continue;
    for (std::size_t i = 0; i < log->channels().size(); ++i) {
      for (const MessagePlace& message : log->messages(i)) std::ignore = log->read(message);
    }
  }
}

TEST_P(LogTest, RefusesNumbersThatStandForTwoChannels) {
  LogPlan plan = plan_;
  plan.channels[1].topic = "/odom2";
  Bytes bytes = written(plan);
  // In the index at the end, the second channel is called otherwise.
  const auto name = std::find_end(bytes.begin(), bytes.end(), "/odom2", "/odom2" + 6);
  if (GetParam() == FileKind::kMcap) {
    name[5] = '3';
    EXPECT_ERROR(read_bytes(bytes), "stands for");
  }
}

TEST(McapFile, RefusesAChunkWhoseSumIsWrong) {
  const roomwise::testing::ScratchFolder folder;
  const LogPlan plan = small_plan(FileKind::kMcap);
  Bytes bytes = McapWriter::write(plan);
  *std::ranges::search(bytes, Bytes(40, 1)).begin() = 9;
  ASSERT_OK(write_file(folder / "a.mcap", bytes));
  EXPECT_ERROR(read_mcap(folder / "a.mcap"), "CRC-32");
}

TEST(McapFile, TimesThatMakeNoSenseHaveADifferenceAllTheSame) {
  const roomwise::testing::ScratchFolder folder;
  LogPlan plan = small_plan(FileKind::kMcap);
  plan.channels[0] = channel("/tf", "tf2_msgs/msg/TFMessage", Encoding::kCdr);
  plan.chunks = {{{0, -1, {}}, {0, 5, {}}}};  // -1 is written as the largest number
  ASSERT_OK(write_file(folder / "a.mcap", McapWriter::write(plan)));
  const auto log = read_mcap(folder / "a.mcap");
  ASSERT_OK(log);
  EXPECT_THAT(times_of(*log, 0), ElementsAre(5, TimestampNs{1} << 62));
}

TEST(McapFile, ReadsAnIndexWithoutChannels) {
  const roomwise::testing::ScratchFolder folder;
  LogPlan plan = small_plan(FileKind::kMcap);
  plan.has_channels_at_end = false;
  // The first chunk describes the channels, and has no message that is read.
  std::swap(plan.chunks[0], plan.chunks[2]);
  ASSERT_OK(write_file(folder / "a.mcap", McapWriter::write(plan)));
  const auto log = read_mcap(folder / "a.mcap");
  ASSERT_OK(log);
  EXPECT_THAT(log->messages(0), SizeIs(2));
}

TEST(McapFile, ReadsMessagesOutsideOfChunks) {
  const roomwise::testing::ScratchFolder folder;
  LogPlan plan = small_plan(FileKind::kMcap);
  plan.has_chunks = false;
  ASSERT_OK(write_file(folder / "a.mcap", McapWriter::write(plan)));
  expect_whole(read_mcap(folder / "a.mcap"), plan);
}

TEST(McapFile, TakesNoMemoryForAChunkThatLiesAboutItsSize) {
  const roomwise::testing::ScratchFolder folder;
  LogPlan plan = small_plan(FileKind::kMcap);
  plan.packing = "zstd";
  Bytes bytes = McapWriter::write(plan);
  const std::size_t first_chunk = 8 + 9 + 4 + 4 + 4;
  for (std::size_t i = 0; i < 8; ++i) bytes[first_chunk + 9 + 16 + i] = i == 4 ? 1 : 0;  // 4 GiB
  ASSERT_OK(write_file(folder / "a.mcap", bytes));
  EXPECT_ERROR(read_mcap(folder / "a.mcap"), "more than any writer makes");
}

TEST(Ros1Bag, ReadsWhatAKilledRecorderLeaves) {
  const roomwise::testing::ScratchFolder folder;
  LogPlan plan = small_plan(FileKind::kBag);
  plan.has_index = false;
  Bytes bytes = BagWriter::write(plan);
  // The head of the chunk in hand has no sizes yet, and its messages follow it.
  const std::string_view size = "size=";
  const auto head = std::find_end(bytes.begin(), bytes.end(), size.begin(), size.end());
  std::fill_n(head + 5, 8, std::uint8_t{0});
  ASSERT_OK(write_file(folder / "a.bag", bytes));
  const auto log = read_ros1_bag(folder / "a.bag");
  ASSERT_OK(log);
  EXPECT_THAT(log->messages(0), SizeIs(2));
}

TEST(Ros1Bag, RefusesWhatIsNone) {
  const roomwise::testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "a.bag", "#ROSBAG V2.0\nand then some text that is no record"));
  EXPECT_ERROR(read_ros1_bag(folder / "a.bag"), "a.bag");
  EXPECT_ERROR(read_ros1_bag(folder / "none.bag"), "cannot be read");
  EXPECT_ERROR(read_ros1_bag(folder.path()), "no regular file");
}

}  // namespace
}  // namespace roomwise::recording
