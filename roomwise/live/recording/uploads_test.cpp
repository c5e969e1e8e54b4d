#include "roomwise/live/recording/uploads.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "roomwise/base/testing/testing.h"

namespace roomwise::live {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

Bytes bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

class UploadsFolder : public ::testing::Test {
 protected:
  UploadsFolder() : uploads(open().value()) {}
  [[nodiscard]] Expected<Uploads> open(UploadLimits limits = {}) const {
    if (!limits.free_bytes) {
      limits.free_bytes = [](const auto&) {
        return Expected<std::uint64_t>(std::uint64_t{1} << 40U);
      };
    }
    return Uploads::open(folder / "uploads", limits);
  }
  [[nodiscard]] std::string there(const std::string& id) const {
    return read_text_file(uploads.file_of(id)).value();
  }

  testing::ScratchFolder folder;
  Uploads uploads;
};

TEST_F(UploadsFolder, AFileComesInPieces) {
  const Upload begun = uploads.begin("scan.zip", 11, "1").value();
  EXPECT_EQ(begun.offset, 0U);
  EXPECT_EQ(uploads.put(begun.id, 0, bytes_of("hello "))->offset, 6U);
  const auto last = uploads.put(begun.id, 6, bytes_of("world"));
  ASSERT_OK(last);
  EXPECT_TRUE(last->is_complete());
  EXPECT_EQ(there(begun.id), "hello world");
  ASSERT_OK(uploads.remove(begun.id));
  EXPECT_THAT(uploads.list().value(), IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(uploads.file_of(begun.id)));
}

// A kill leaves the file as long as it was at any byte; what is asked first is where to go on.
TEST_F(UploadsFolder, WhereverItWasStoppedItGoesOn) {
  const std::string whole = "0123456789abcdef";
  for (std::size_t stopped = 0; stopped < whole.size(); ++stopped) {
    const Upload begun = uploads.begin("scan.zip", whole.size(), std::to_string(stopped)).value();
    ASSERT_OK(write_file(uploads.file_of(begun.id), whole.substr(0, stopped)));
    auto later = open().value();  // the computer started again
    const Upload again = later.begin("scan.zip", whole.size(), std::to_string(stopped)).value();
    ASSERT_EQ(again.id, begun.id);
    ASSERT_EQ(again.offset, stopped);
    ASSERT_OK(later.put(again.id, again.offset, bytes_of(whole.substr(stopped))));
    EXPECT_EQ(there(begun.id), whole);
    ASSERT_OK(later.remove(begun.id));
  }
}

// An answer that was lost has the same piece sent again.
TEST_F(UploadsFolder, WhatIsDamagedIsSetAsideAndTheOthersStay) {
  const Upload damaged = uploads.begin("scan.zip", 11, "1").value();
  const Upload whole = uploads.begin("other.zip", 11, "2").value();
  const auto facts = folder / "uploads" / (damaged.id + ".json");
  ASSERT_OK(write_file(facts, std::string_view("{")));
  const auto listed = uploads.list().value();
  ASSERT_THAT(listed, SizeIs(1));
  EXPECT_EQ(listed[0].id, whole.id);
  EXPECT_EQ(read_text_file(facts.string() + ".damaged").value(), "{");
  EXPECT_EQ(uploads.begin("scan.zip", 11, "1")->id, damaged.id) << "it can be sent anew";
}

TEST_F(UploadsFolder, APieceThatIsSentAgainChangesNothing) {
  const Upload begun = uploads.begin("scan.zip", 10, "1").value();
  ASSERT_OK(uploads.put(begun.id, 0, bytes_of("01234")));
  EXPECT_EQ(uploads.put(begun.id, 0, bytes_of("01234"))->offset, 5U);
  EXPECT_EQ(uploads.put(begun.id, 3, bytes_of("34567"))->offset, 8U) << "half of it was there";
  EXPECT_EQ(there(begun.id), "01234567");
}

TEST_F(UploadsFolder, APieceThatLeavesAGapOrIsTooLongIsRefused) {
  const Upload begun = uploads.begin("scan.zip", 10, "1").value();
  ASSERT_OK(uploads.put(begun.id, 0, bytes_of("01234")));
  EXPECT_ERROR(uploads.put(begun.id, 6, bytes_of("6")), "go on from 5");
  EXPECT_ERROR(uploads.put(begun.id, 5, bytes_of("567890")), "beyond the file's 10 bytes");
  EXPECT_ERROR(uploads.put(begun.id, std::uint64_t{1} << 63U, bytes_of("1")), "go on from 5");
  EXPECT_EQ(there(begun.id), "01234");
}

TEST_F(UploadsFolder, AnIdIsNoPath) {
  for (const std::string id : {"", "../../etc/passwd", "x", "0123456789abcdef0123456/"}) {
    EXPECT_FALSE(uploads.find(id)) << id;
    EXPECT_FALSE(uploads.put(id, 0, bytes_of("1"))) << id;
    EXPECT_FALSE(uploads.remove(id)) << id;
  }
}

TEST_F(UploadsFolder, WhatHasNoRoomIsRefusedAtTheBeginning) {
  auto small = open({.max_bytes = 100,
                     .max_uploads = 2,
                     .reserve_bytes = 1000,
                     .free_bytes = [](const auto&) { return Expected<std::uint64_t>(1120U); }})
                   .value();
  EXPECT_ERROR(small.begin("a", 101, ""), "at most");
  ASSERT_OK(small.begin("a", 80, ""));
  EXPECT_ERROR(small.begin("b", 80, ""), "free some space");
  ASSERT_OK(small.begin("b", 40, ""));
  EXPECT_ERROR(small.begin("c", 1, ""), "2 files wait");
  EXPECT_THAT(small.list().value(), SizeIs(2));
}

TEST_F(UploadsFolder, OnADiskThatFillsUpMeanwhileWhatCameStays) {
  const Upload begun = uploads.begin("scan.zip", 2000, "1").value();
  ASSERT_OK(uploads.put(begun.id, 0, Bytes(400, 'a')));
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{700, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto put = uploads.put(begun.id, 400, Bytes(1600, 'b'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_ERROR(put, "free some space");
  EXPECT_EQ(put.error().code, ErrorCode::kDiskFull);
  const Upload now = uploads.find(begun.id).value();
  EXPECT_EQ(now.offset, 700U) << "as far as it went";
  ASSERT_OK(uploads.put(begun.id, now.offset, Bytes(1300, 'b')));
  EXPECT_EQ(there(begun.id), std::string(400, 'a') + std::string(1600, 'b'));
}

}  // namespace
}  // namespace roomwise::live
