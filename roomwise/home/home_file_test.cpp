// The home as a file: what is made, opened, refused, shared.

#include <sys/stat.h>

#include <fstream>

#include "roomwise/home/schema.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class HomeFile : public ::testing::Test {
 protected:
  // A closed home with something in every table; its digest.
  std::string make() const {
    Home home = Home::create(path_).value();
    testing::fill(home);
    return home.content_digest().value();
  }
  // Neither way to open the home works, both say why, and no byte of the folder changes.
  void expect_refused(const std::string& why) const {
    const auto before = contents();
    EXPECT_ERROR(Home::open(path_), why);
    EXPECT_EQ(contents(), before);
    EXPECT_ERROR(Home::open_read_only(path_), why);
    EXPECT_EQ(contents(), before);
  }
  // Every file of the folder and its bytes.
  [[nodiscard]] std::map<std::string, Bytes> contents() const {
    std::map<std::string, Bytes> contents;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      contents[entry.path().filename()] = read_file(entry.path()).value();
    }
    return contents;
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& [name, bytes] : contents()) names.push_back(name);
    return names;
  }
  void run_sql(const std::string& sql) const {
    Database database = Database::open(path_, Database::Access::kReadWrite).value();
    ASSERT_OK(database.run_script(sql));
  }
  // Makes a home whose writer is killed, so that a part of it is still beside it.
  void make_and_kill() const {
    const int status = testing::run_in_child([&] {
      Home home = Home::create(path_).value();
      testing::fill(home);
      return ::kill(::getpid(), SIGKILL);
    });
    ASSERT_TRUE(WIFSIGNALED(status));
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.home";
};

TEST_F(HomeFile, IsOneFileOnceClosed) {
  const std::string digest = make();
  EXPECT_THAT(files(), ElementsAre("a.home"));
  EXPECT_EQ(Home::open(path_)->content_digest().value(), digest);
  EXPECT_EQ(Home::open_read_only(path_)->content_digest().value(), digest);
  EXPECT_THAT(files(), ElementsAre("a.home"));
}

TEST_F(HomeFile, IsKnownByItsFirstBytes) {
  make();
  const Database database = Database::open(path_, Database::Access::kReadOnly).value();
  const auto header = database.header().value();
  EXPECT_EQ(header.application_id, kApplicationId);
  EXPECT_EQ(header.user_version, kHomeVersion);
}

TEST_F(HomeFile, IsNotMadeOverAnotherFile) {
  make();
  const auto before = contents();
  EXPECT_ERROR(Home::create(path_), "a.home: exists already");
  EXPECT_EQ(contents(), before);
  EXPECT_ERROR(Home::create(folder_ / "nowhere" / "a.home"), "cannot be made");
}

TEST_F(HomeFile, ReadingChangesNothing) {
  make();
  const auto before = contents();
  {
    Home home = Home::open_read_only(path_).value();
    EXPECT_OK(home.verify());
    EXPECT_ERROR(home.put_setting("seed", "8"), "cannot be written");
  }
  EXPECT_EQ(contents(), before);
}

TEST_F(HomeFile, RefusesATextFile) {
  ASSERT_OK(write_file(path_, std::string(500, 'x')));
  expect_refused("a.home: is no home file (not a SQLite database)");
  ASSERT_OK(write_file(path_, std::string_view("short")));
  expect_refused("is no home file");
}

TEST_F(HomeFile, RefusesAnEmptyFile) {
  ASSERT_OK(write_file(path_, std::string_view()));
  expect_refused("is empty");
}

TEST_F(HomeFile, IsInUseWhileAnotherProcessMakesIt) {
  const auto lock = WriterLock::take(path_);
  ASSERT_OK(lock);
  ASSERT_OK(write_file(path_, std::string_view()));
  EXPECT_ERROR(Home::open(path_), "in use by another process");
  EXPECT_ERROR(Home::open_read_only(path_), "in use by another process");
  EXPECT_ERROR(Home::create(path_), "in use by another process");
}

TEST_F(HomeFile, AChangeThatAKilledWriterBeganIsTakenBackBeforeReading) {
  const std::string digest = make();
  const int status = testing::run_in_child([&] {
    Database database = Database::open(path_, Database::Access::kReadWrite).value();
    if (!database.run_script("PRAGMA journal_mode = DELETE; PRAGMA cache_size = 1; BEGIN; "
                             "UPDATE keyframe_images SET color = zeroblob(500000)")) {
      return 1;
    }
    return ::kill(::getpid(), SIGKILL);
  });
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_GT(std::filesystem::file_size(folder_ / "a.home-journal"), 0U);
  const auto home = Home::open_read_only(path_);
  ASSERT_OK(home);
  EXPECT_EQ(home->content_digest().value(), digest);
}

TEST_F(HomeFile, RefusesWhatIsNotThere) {
  expect_refused("no such file");
}

TEST_F(HomeFile, RefusesTheDatabaseOfAnotherProgram) {
  for (const std::string mode : {"DELETE", "WAL"}) {
    std::filesystem::remove(path_);
    ASSERT_OK(write_file(path_, std::string_view()));
    run_sql("PRAGMA journal_mode = " + mode + "; CREATE TABLE bookmarks (url TEXT)");
    expect_refused("not a home of Roomwise");
  }
}

TEST_F(HomeFile, RefusesANewerVersion) {
  make();
  run_sql("PRAGMA user_version = 2");
  expect_refused(
      "a.home: was written by another Roomwise (home version 2; this one reads version 1); update "
      "Roomwise, or map the recordings again into a new home");
}

TEST_F(HomeFile, RefusesANewerVersionThatIsOnlyInTheLog) {
  make();
  const int status = testing::run_in_child([&] {
    Database database = Database::open(path_, Database::Access::kReadWrite).value();
    if (!database.run_script("PRAGMA journal_mode = WAL; PRAGMA user_version = 2")) return 1;
    return ::kill(::getpid(), SIGKILL);
  });
  ASSERT_TRUE(WIFSIGNALED(status));
  const Bytes before = read_file(path_).value();
  const Bytes log_before = read_file(folder_ / "a.home-wal").value();
  EXPECT_ERROR(Home::open(path_), "another Roomwise (home version 2");
  EXPECT_ERROR(Home::open_read_only(path_), "another Roomwise (home version 2");
  EXPECT_EQ(read_file(path_).value(), before);
  EXPECT_EQ(read_file(folder_ / "a.home-wal").value(), log_before);
}

TEST_F(HomeFile, RefusesATruncatedFile) {
  make();
  const auto size = std::filesystem::file_size(path_);
  for (const auto kept : {size - 1, size / 2, std::uintmax_t{4096}, std::uintmax_t{100}}) {
    std::filesystem::resize_file(path_, kept);
    expect_refused(fmt::format("is truncated: {} of {} bytes", kept, size));
  }
  std::filesystem::resize_file(path_, 50);
  expect_refused("is no home file");
}

TEST_F(HomeFile, RefusesAMissingTable) {
  make();
  run_sql("DROP TABLE has_a");
  const Bytes before = read_file(path_).value();
  EXPECT_ERROR(Home::open(path_), "no table 'has_a'");
  EXPECT_ERROR(Home::open_read_only(path_), "no table 'has_a'");
  EXPECT_EQ(read_file(path_).value(), before);
}

// Every page in turn is overwritten. None may crash, none may pass verify(), and opening for
// writing either refuses the file untouched or (the images) leaves the damage to verify().
TEST_F(HomeFile, FindsDamageInAnyPage) {
  make();
  const Bytes whole = read_file(path_).value();
  constexpr std::size_t kPage = 4096;
  ASSERT_GT(whole.size() / kPage, 20U);
  std::size_t refused = 0;
  for (std::size_t page = 0; page * kPage < whole.size(); ++page) {
    Bytes damaged = whole;
    // The first page keeps its header, which other tests spoil.
    const std::size_t begin = page == 0 ? 100 : page * kPage;
    std::fill(damaged.begin() + static_cast<std::ptrdiff_t>(begin),
              damaged.begin() + static_cast<std::ptrdiff_t>((page + 1) * kPage),
              std::uint8_t{0xa5});
    std::filesystem::remove(path_);  // write_file() would refuse to replace a home
    ASSERT_OK(write_file(path_, damaged));
    if (auto reader = Home::open_read_only(path_)) {
      EXPECT_FALSE(reader->verify()) << "page " << page;
    } else {
      EXPECT_THAT(reader.error().message, HasSubstr("a.home: is damaged"));
    }
    EXPECT_EQ(read_file(path_).value(), damaged);
    if (auto writer = Home::open(path_)) continue;
    EXPECT_EQ(read_file(path_).value(), damaged);
    EXPECT_THAT(files(), ElementsAre("a.home"));
    ++refused;
  }
  EXPECT_GT(refused, 20U);
}

TEST_F(HomeFile, IsWrittenByOneAtATime) {
  Home first = Home::create(path_).value();
  EXPECT_ERROR(Home::open(path_), "a.home: in use by another process");
  const int status = testing::run_in_child([&] {
    const auto second = Home::open(path_);
    return !second && second.error().message.find("in use by another") != std::string::npos ? 0 : 1;
  });
  EXPECT_EQ(status, 0);
  EXPECT_OK(first.put_setting("seed", "8"));
}

TEST_F(HomeFile, IsReadWhileItIsWritten) {
  make();
  Home writer = Home::open(path_).value();
  ASSERT_OK(writer.put_setting("seed", "8"));
  {
    Home reader = Home::open_read_only(path_).value();
    EXPECT_EQ(reader.settings()->at("seed"), "8");
    ASSERT_OK(writer.put_setting("seed", "9"));
    EXPECT_EQ(reader.settings()->at("seed"), "9");
    const auto inside = writer.atomically([&]() -> Expected<void> {
      ROOMWISE_RETURN_IF_ERROR(writer.put_setting("seed", "10"));
      EXPECT_EQ(reader.settings()->at("seed"), "9") << "not committed";
      return {};
    });
    ASSERT_OK(inside);
  }
  EXPECT_EQ(Home::open_read_only(path_)->settings()->at("seed"), "10");
}

TEST_F(HomeFile, AReaderOutlivesTheWriter) {
  std::optional<Home> reader;
  std::string digest;
  {
    Home writer = Home::create(path_).value();
    testing::fill(writer);
    digest = writer.content_digest().value();
    reader.emplace(Home::open_read_only(path_).value());
    EXPECT_EQ(reader->content_digest().value(), digest);
  }
  EXPECT_EQ(reader->content_digest().value(), digest);
  reader.reset();
  EXPECT_EQ(Home::open(path_)->content_digest().value(), digest);
  EXPECT_THAT(files(), ElementsAre("a.home"));
}

TEST_F(HomeFile, OfAKilledWriterIsReadWithoutChangingIt) {
  make_and_kill();
  ASSERT_THAT(files(), ElementsAre("a.home", "a.home-lock", "a.home-shm", "a.home-wal"));
  const Bytes before = read_file(path_).value();
  const Bytes log_before = read_file(folder_ / "a.home-wal").value();
  std::string digest;
  {
    Home reader = Home::open_read_only(path_).value();
    EXPECT_THAT(reader.keyframes().value(), ::testing::SizeIs(4));
    EXPECT_OK(reader.verify());
    digest = reader.content_digest().value();
  }
  EXPECT_EQ(read_file(path_).value(), before);
  EXPECT_EQ(read_file(folder_ / "a.home-wal").value(), log_before);
  EXPECT_EQ(Home::open(path_)->content_digest().value(), digest);
  EXPECT_THAT(files(), ElementsAre("a.home")) << "the next writer tidies";
}

// Runs work() as a user for whom the folder and its files are read-only, as on a read-only medium.
int run_without_write_permission(const std::filesystem::path& folder,
                                 const std::function<int()>& work) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    ::chmod(entry.path().c_str(), 0444);
  }
  ::chmod(folder.c_str(), 0555);
  const int status = testing::run_in_child([&] {
    if (::getuid() == 0 && ::setuid(65534) != 0) return 100;
    return work();
  });
  ::chmod(folder.c_str(), 0755);
  return status;
}

TEST_F(HomeFile, IsReadFromAMediumThatCannotBeWritten) {
  const std::string digest = make();
  const auto read = [&] {
    const auto home = Home::open_read_only(path_);
    if (!home) return 1;
    return home->content_digest() == digest ? 0 : 2;
  };
  EXPECT_EQ(run_without_write_permission(folder_.path(), read), 0);
  // A home that was not closed in the usual way but lacks nothing.
  ::chmod(path_.c_str(), 0644);
  run_sql("PRAGMA journal_mode = WAL");
  ASSERT_THAT(files(), ElementsAre("a.home"));
  EXPECT_EQ(run_without_write_permission(folder_.path(), read), 0);
}

TEST_F(HomeFile, SaysWhatToDoWhereAPermissionIsMissing) {
  make();
  const auto refused = [&](const std::function<Expected<Home>()>& open, const char* why) {
    const int status = run_without_write_permission(folder_.path(), [&] {
      const auto home = open();
      return !home && home.error().message.find(why) != std::string::npos ? 0 : 1;
    });
    EXPECT_EQ(status, 0) << why;
  };
  refused([&] { return Home::open(path_); }, "you may not write it; change its permissions");
  refused([&] { return Home::create(folder_ / "b.home"); }, "b.home: cannot be made");
}

TEST_F(HomeFile, OfAKilledWriterOnAReadOnlyMediumNeedsAllItsFiles) {
  make_and_kill();
  const auto open = [&] {
    const auto home = Home::open_read_only(path_);
    if (home) return home->keyframes()->size() == 4 ? 0 : 1;
    return home.error().message.find("was not closed, and its folder cannot") == std::string::npos
               ? 2
               : 3;
  };
  EXPECT_EQ(run_without_write_permission(folder_.path(), open), 0);
  std::filesystem::remove(folder_ / "a.home-shm");
  EXPECT_EQ(WEXITSTATUS(run_without_write_permission(folder_.path(), open)), 3);
}

}  // namespace
}  // namespace roomwise::home
