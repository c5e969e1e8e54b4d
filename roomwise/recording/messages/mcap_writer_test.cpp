#include "roomwise/recording/messages/mcap_writer.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/messages/mcap_file.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Read by others, too: tests/export_formats_test.cpp.
TEST(McapFileWriters, WriteWhatIsReadBack) {
  const ScratchFolder folder;
  auto writer = McapFileWriter::create(folder / "a.mcap");
  ASSERT_OK(writer);
  const auto first = writer->add_json_channel("/tf", "foxglove.FrameTransform", "{}");
  const auto second = writer->add_json_channel("/other", "foxglove.FrameTransform", "{}");
  const std::string long_message = "{\"a\":\"" + std::string(700'000, 'x') + "\"}";
  for (int i = 0; i < 6; ++i) {
    EXPECT_OK(writer->write(i % 2 == 0 ? first : second, 1'000 + i, long_message));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap")) << "not before it is whole";
  EXPECT_OK(writer->finish());
  const auto log = read_mcap(folder / "a.mcap");
  ASSERT_OK(log);
  EXPECT_THAT(log->notes(), IsEmpty());
  EXPECT_THAT(log->channels(), SizeIs(2));
  ASSERT_THAT(log->messages(1), SizeIs(3));
  EXPECT_EQ(log->messages(1)[2].logged_ns, 1'005);
  EXPECT_EQ(log->messages(1)[2].chunk, 2) << "two of these messages are more than a MiB";
  const auto message = log->read(log->messages(1)[2]);
  ASSERT_OK(message);
  EXPECT_EQ(std::string(message->begin(), message->end()), long_message);
}

TEST(McapFileWriters, LeaveNothingWhereTheyDoNotFinish) {
  const ScratchFolder folder;
  {
    auto writer = McapFileWriter::create(folder / "a.mcap");
    ASSERT_OK(writer);
    EXPECT_ERROR(writer->write(writer->add_json_channel("/a", "b", "{}"), -1, "{}"), "before 0");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_OK(write_file(folder / "there", std::string_view("mine")));
  EXPECT_ERROR(McapFileWriter::create(folder / "there"), "is not overwritten");
}

}  // namespace
}  // namespace roomwise::recording
