#include "roomwise/live/home/home_backup.h"

#include <gtest/gtest.h>

#include <fstream>

#include "roomwise/home/testing/sample_home.h"
#include "roomwise/home/writer_lock.h"
#include "roomwise/service/access/access.h"

namespace roomwise::live {
namespace {

namespace fs = std::filesystem;
using ::roomwise::testing::ScratchFolder;

class HomeBackup : public ::testing::Test {
 protected:
  HomeBackup() {
    home::Home home = home::Home::create(home_).value();
    home::testing::fill(home);
    digest_ = home.content_digest().value();
    put(folder_ / "a.home.access" / "key.pem", "secret");
    put(folder_ / "a.home.photos" / "kitchen" / "1.jpg", "picture");
    put(folder_ / "a.home.walks" / "monday" / "rgb" / "1.jpg", "walk");
    put(folder_ / "a.home.uploads" / "part", "half");
    put(folder_ / "a.home.lenses.json", "{}");
    put(folder_ / "b.home.photos" / "1.jpg", "of another home");
  }
  static void put(const fs::path& path, std::string_view text) {
    fs::create_directories(path.parent_path());
    ASSERT_OK(write_file(path, text));
  }
  [[nodiscard]] static Expected<Backup> make(const fs::path& home, const fs::path& folder,
                                             const BackupOptions& options = {}) {
    ROOMWISE_TRY(const home::Home open, home::Home::open_read_only(home));
    return back_up(open, folder, options);
  }

  ScratchFolder folder_;
  fs::path home_ = folder_ / "a.home", backup_ = folder_ / "sunday";
  std::string digest_;
};

TEST_F(HomeBackup, ComesBackUnderAnotherName) {
  EXPECT_EQ(make(home_, backup_)->files, 5U);
  const fs::path back = folder_ / "back.home";
  EXPECT_EQ(restore(backup_, back)->files, 5U);
  EXPECT_EQ(home::Home::open(back)->content_digest().value(), digest_);
  EXPECT_EQ(read_text_file(folder_ / "back.home.access" / "key.pem").value(), "secret");
  EXPECT_EQ(read_text_file(folder_ / "back.home.photos" / "kitchen" / "1.jpg").value(), "picture");
  EXPECT_EQ(read_text_file(folder_ / "back.home.walks" / "monday" / "rgb" / "1.jpg").value(),
            "walk");
  EXPECT_FALSE(fs::exists(folder_ / "back.home.uploads"));
}

TEST_F(HomeBackup, TellsOfDevicesThatArePairedAgainAndLeavesThemOutWhereAsked) {
  const auto open = [&](const char* home) {
    return service::AccessRegister::open(service::access_folder(folder_ / home), "").value();
  };
  fs::permissions(folder_ / "a.home.access", fs::perms::owner_all);
  std::string token;
  {
    const auto access = open("a.home");
    const auto lost = access->pair_here(service::Role::kHelper, "lost phone", {}).value();
    token = lost.token;
    ASSERT_OK(access->pair_here(service::Role::kDevice, "cap", {}));
    ASSERT_OK(make(home_, backup_));
    EXPECT_EQ(access->revoke(lost.who.device), true);
  }
  EXPECT_EQ(restore(backup_, folder_ / "with.home")->devices, 2U);
  EXPECT_TRUE(open("with.home")->identify(token, {}));
  EXPECT_EQ(restore(backup_, folder_ / "without.home", {.with_devices = false})->devices, 0U);
  const auto without = open("without.home");
  EXPECT_FALSE(without->identify(token, {}));
  EXPECT_EQ(without->pair_here(service::Role::kDevice, "new", {})->who.device, 3)
      << "what is another device's stays its own";
  EXPECT_EQ(read_text_file(folder_ / "without.home.access" / "key.pem").value(), "secret");
}

TEST_F(HomeBackup, IsItsOwnersAlone) {
  ASSERT_OK(make(home_, backup_));
  EXPECT_EQ(fs::status(backup_).permissions(), fs::perms::owner_all);
  EXPECT_EQ(fs::status(backup_ / "a.home.access" / "key.pem").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(HomeBackup, LeavesTheWalksOutWhereAsked) {
  EXPECT_EQ(make(home_, backup_, {.with_walks = false})->files, 4U);
  EXPECT_FALSE(fs::exists(backup_ / "a.home.walks"));
}

TEST_F(HomeBackup, IsNotMadeOfADamagedHome) {
  {
    std::fstream file(home_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(5 * 4096 + 100);
    file.put('!');
  }
  EXPECT_FALSE(make(home_, backup_));
  EXPECT_FALSE(fs::exists(backup_));
  EXPECT_FALSE(fs::exists(folder_ / "sunday.part"));
}

TEST_F(HomeBackup, OverwritesNothing) {
  ASSERT_OK(make(home_, backup_));
  EXPECT_ERROR(make(home_, backup_), "sunday: is there");
  EXPECT_ERROR(restore(backup_, home_), "a.home: is there");
  EXPECT_ERROR(restore(backup_, folder_ / "b.home"), "b.home.photos: is there");
  EXPECT_EQ(read_text_file(folder_ / "b.home.photos" / "1.jpg").value(), "of another home");
  EXPECT_EQ(home::Home::open(home_)->content_digest().value(), digest_);
}

TEST_F(HomeBackup, AnotherIntoTheSameFolderMustWait) {
  {
    const auto other = home::WriterLock::take(backup_);
    ASSERT_OK(other);
    put(folder_ / "sunday.part" / "a.home", "half of the other's");
    EXPECT_ERROR(make(home_, backup_), "sunday: in use by another process");
    EXPECT_EQ(read_text_file(folder_ / "sunday.part" / "a.home").value(), "half of the other's");
  }
  ASSERT_OK(make(home_, backup_)) << "what a backup that was stopped left";
  const fs::path back = folder_ / "back.home";
  {
    const auto other = home::WriterLock::take(back);
    EXPECT_ERROR(restore(backup_, back), "back.home: in use by another process");
  }
  EXPECT_OK(restore(backup_, back));
}

// The log of a home that was moved away would be played into the one that comes.
TEST_F(HomeBackup, IsNotRestoredBesideALogThatWasLeft) {
  ASSERT_OK(make(home_, backup_));
  put(folder_ / "c.home-wal", "left");
  EXPECT_ERROR(restore(backup_, folder_ / "c.home"), "c.home-wal: is there");
  EXPECT_EQ(read_text_file(folder_ / "c.home-wal").value(), "left");
}

TEST_F(HomeBackup, LeavesNothingBesideWhatItMakes) {
  const home::Home writer = home::Home::open(home_).value();  // keeps a log
  ASSERT_OK(make(home_, backup_));
  ASSERT_OK(restore(backup_, folder_ / "c.home"));
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.starts_with("a.home") || !name.ends_with("-wal")) << name;
    EXPECT_EQ(name.find(".part"), std::string::npos) << name;
    EXPECT_EQ(name.find(".restored"), std::string::npos) << name;
  }
  EXPECT_FALSE(fs::exists(backup_ / "a.home-wal"));
}

TEST_F(HomeBackup, IsToldFromOtherFolders) {
  fs::create_directory(folder_ / "empty");
  EXPECT_ERROR(restore(folder_ / "empty", folder_ / "c.home"), "holds 0 homes");
  EXPECT_ERROR(restore(folder_ / "missing", folder_ / "c.home"), "cannot be read");
}

}  // namespace
}  // namespace roomwise::live
