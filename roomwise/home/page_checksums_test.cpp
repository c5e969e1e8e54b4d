// What a disk or a copy did to a home is noticed wherever it is read.
#include "roomwise/home/page_checksums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "roomwise/base/random.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;

class PageChecksums : public ::testing::Test {
 protected:
  // A closed home with something in every table, and its bytes.
  PageChecksums() {
    Home home = Home::create(path_).value();
    testing::fill(home);
    digest_ = home.content_digest().value();
    { const Home closed = std::move(home); }
    bytes_ = read_file(path_).value();
    page_bytes_ = std::size_t{bytes_[16]} << 8 | std::size_t{bytes_[17]};
  }
  void put(const Bytes& bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  // What the home holds, or why that cannot be said.
  [[nodiscard]] Expected<std::string> digest() const {
    ROOMWISE_TRY(const Home home, Home::open_read_only(path_));
    return home.content_digest();
  }
  // By a connection of its own.
  [[nodiscard]] PageCheck checked() const {
    const Database database = Database::open(path_, Database::Access::kReadOnly).value();
    EXPECT_OK(database.get<int>("PRAGMA user_version"));
    return check_pages(database.handle(), database.file()).value();
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.home";
  Bytes bytes_;
  std::string digest_;
  std::size_t page_bytes_ = 0;
};

TEST_F(PageChecksums, OfAWholeHomeAreRight) {
  const PageCheck check = checked();
  EXPECT_EQ(check.pages, bytes_.size() / page_bytes_);
  EXPECT_TRUE(check.damaged.empty());
  EXPECT_EQ(digest().value(), digest_);
}

TEST_F(PageChecksums, NoticeEveryBitThatChanges) {
  RandomStream random(7);
  for (int i = 0; i < 200; ++i) {
    Bytes damaged = bytes_;
    const auto at = static_cast<std::size_t>(random.index(bytes_.size()));
    damaged[at] ^= static_cast<std::uint8_t>(1U << random.index(8));
    put(damaged);
    const auto now = digest();
    const bool is_unread = now.has_value() && *now == digest_;
    EXPECT_TRUE(!now.has_value() || is_unread) << "byte " << at;
    // What the digest does not read is found by the check.
    if (is_unread) {
      EXPECT_EQ(checked().damaged, std::vector<std::uint64_t>{at / page_bytes_ + 1})
          << "byte " << at;
    }
  }
}

TEST_F(PageChecksums, NoticeAPageInThePlaceOfAnother) {
  Bytes damaged = bytes_;
  const auto page = [&](std::size_t number) {
    return damaged.begin() + static_cast<std::ptrdiff_t>((number - 1) * page_bytes_);
  };
  std::swap_ranges(page(3), page(4), page(5));
  put(damaged);
  EXPECT_EQ(checked().damaged, (std::vector<std::uint64_t>{3, 5}));
}

TEST_F(PageChecksums, AreWrittenWithEveryChange) {
  {
    Home home = Home::open(path_).value();
    ASSERT_OK(home.put_setting("method", "another one"));
    ASSERT_OK(home.erase_removed());
  }
  EXPECT_TRUE(checked().damaged.empty());
  EXPECT_NE(digest().value(), digest_);
}

TEST_F(PageChecksums, SayWhatIsWrongAndWhatHelps) {
  Bytes damaged = bytes_;
  damaged[3 * page_bytes_ / 2] ^= 1;  // of the second page
  put(damaged);
  EXPECT_ERROR(Home::open(path_), "is damaged");
  EXPECT_ERROR(Home::open(path_), "see what is left of it with: roomwise check");
}

TEST_F(PageChecksums, CannotBeLeftOutOfAHome) {
  Bytes without = bytes_;
  without[20] = 0;
  put(without);
  EXPECT_ERROR(Home::open(path_), "its pages have no checksums");
  EXPECT_ERROR(Home::open_read_only(path_), "its pages have no checksums");
}

TEST_F(PageChecksums, AreNotAskedOfOtherDatabases) {
  const std::filesystem::path path = folder_ / "other.sqlite";
  std::ofstream(path).close();
  Database database = Database::open(path, Database::Access::kReadWrite).value();
  ASSERT_OK(database.run_script("CREATE TABLE t (a); INSERT INTO t VALUES (7)"));
  EXPECT_EQ(database.get<int>("SELECT a FROM t").value(), 7);
  EXPECT_ERROR(check_pages(database.handle(), database.file()), "no checksums");
}

}  // namespace
}  // namespace roomwise::home
