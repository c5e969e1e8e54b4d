// What a check says of a home, and copies of homes.
#include <fstream>

#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class HomeChecked : public ::testing::Test {
 protected:
  HomeChecked() {
    Home home = Home::create(path_).value();
    testing::fill(home);
    digest_ = home.content_digest().value();
  }
  [[nodiscard]] static HomeCheck check(const std::filesystem::path& path) {
    return Home::open_read_only(path)->check().value();
  }
  void run_sql(const std::string& sql) const {
    Database database = Database::open(path_, Database::Access::kReadWrite).value();
    ASSERT_OK(database.run_script(sql));
  }
  // Turns a bit where the file has these bytes.
  void damage(std::string_view bytes) const {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    const std::string content{std::istreambuf_iterator<char>(file), {}};
    const std::size_t at = content.find(bytes);
    ASSERT_NE(at, std::string::npos);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(content[at] ^ 1));
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.home";
  std::string digest_;
};

TEST_F(HomeChecked, IsWhole) {
  const HomeCheck found = check(path_);
  EXPECT_TRUE(found.is_whole());
  EXPECT_GT(found.pages, 20U);
  EXPECT_THAT(found.doubtful_cameras, IsEmpty());
}

TEST_F(HomeChecked, LosesOnlyThePictureThatIsDamaged) {
  const Bytes color = Home::open_read_only(path_)->images(1)->color;
  ASSERT_GT(color.size(), 8U);
  damage({reinterpret_cast<const char*>(color.data()), color.size()});
  const HomeCheck found = check(path_);
  EXPECT_FALSE(found.is_whole());
  EXPECT_EQ(found.damaged_pages.size(), 1U);
  EXPECT_THAT(found.damaged_tables, ElementsAre("keyframe_images"));
  EXPECT_TRUE(found.lost_pictures.contains(1));
  EXPECT_ERROR(Home::open_read_only(path_)->verify(), "roomwise check");
}

TEST_F(HomeChecked, NamesWhatBelongsToNothing) {
  run_sql("PRAGMA foreign_keys = OFF; UPDATE instance_names SET instance_id = instance_id + 100");
  EXPECT_THAT(check(path_).broken_references, ElementsAre("instance_names"));
}

TEST_F(HomeChecked, NamesACameraThatCannotBe) {
  run_sql("UPDATE recordings SET fx_px = 1e300");
  const HomeCheck found = check(path_);
  EXPECT_TRUE(found.is_whole());
  ASSERT_FALSE(found.doubtful_cameras.empty());
  EXPECT_THAT(found.doubtful_cameras[0], ::testing::HasSubstr("focal length"));
}

TEST_F(HomeChecked, IsCopiedWhileItIsWritten) {
  Home writer = Home::open(path_).value();
  ASSERT_OK(writer.put_setting("method", "another one"));  // lies in the log
  const std::filesystem::path copy = folder_ / "copy.home";
  ASSERT_OK(Home::open_read_only(path_)->copy_to(copy));
  ASSERT_OK(writer.put_setting("method", "a third one"));
  EXPECT_EQ(Home::open(copy)->settings().value().at("method"), "another one");
  EXPECT_TRUE(check(copy).is_whole());
  EXPECT_ERROR(writer.copy_to(copy), "exists already");
}

// More than SQLite keeps in memory, and all of it in the log yet.
TEST_F(HomeChecked, IsCopiedWholeWhereItIsLarge) {
  Home writer = Home::open(path_).value();
  ASSERT_OK(writer.put_derived_data({"floor", "one", Bytes(6'000'000, 7)}));
  const std::filesystem::path copy = folder_ / "copy.home";
  ASSERT_OK(Home::open_read_only(path_)->copy_to(copy));
  EXPECT_TRUE(check(copy).is_whole());
  EXPECT_EQ(Home::open_read_only(copy)->derived_data("floor").value()->data.size(), 6'000'000U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "copy.home-wal"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "copy.home.part-wal"));
}

TEST_F(HomeChecked, IsNotCopiedWhereItIsDamaged) {
  const Bytes color = Home::open_read_only(path_)->images(1)->color;
  damage({reinterpret_cast<const char*>(color.data()), color.size()});
  const std::filesystem::path copy = folder_ / "copy.home";
  EXPECT_ERROR(Home::open_read_only(path_)->copy_to(copy), path_.string() + ": is damaged");
  EXPECT_FALSE(std::filesystem::exists(copy));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "copy.home.part"));
}

}  // namespace
}  // namespace roomwise::home
