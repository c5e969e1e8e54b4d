#include "laboratory/simulation/furniture/furniture_archive.h"

#include <gmock/gmock.h>
#include <zip.h>

#include <algorithm>

#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

constexpr std::string_view kContent = "what the model is called";

// An archive with one file, not packed, so that a test finds its bytes.
void write_archive(const std::filesystem::path& path) {
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE, &code);
  ASSERT_NE(archive, nullptr);
  zip_source_t* source = zip_source_buffer(archive, kContent.data(), kContent.size(), 0);
  const zip_int64_t index = zip_file_add(archive, "house/bed/bed.txt", source, ZIP_FL_ENC_UTF_8);
  ASSERT_GE(index, 0);
  ASSERT_EQ(zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0),
            0);
  ASSERT_EQ(zip_close(archive), 0);
}

TEST(FurnitureArchive, ReadsAndListsItsFiles) {
  const testing::ScratchFolder folder;
  write_archive(folder / "a.sh3f");
  const auto archive = FurnitureArchive::open(folder / "a.sh3f");
  ASSERT_OK(archive);
  const auto bytes = archive->read("house/bed/bed.txt");
  ASSERT_OK(bytes);
  EXPECT_EQ(std::string(bytes->begin(), bytes->end()), kContent);
  EXPECT_THAT(archive->files_in("house/bed"), ::testing::ElementsAre("bed.txt"));
  EXPECT_THAT(archive->files_in("house/be"), ::testing::IsEmpty());
  EXPECT_ERROR(archive->read("house/bed/chair.txt"), "chair.txt: not in the archive");
}

TEST(FurnitureArchive, TellsOfDamageAndNamesThePackage) {
  const testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "junk.sh3f", std::string_view("this is not a zip archive")));
  EXPECT_ERROR(FurnitureArchive::open(folder / "junk.sh3f"), "sweethome3d-furniture");
  EXPECT_ERROR(FurnitureArchive::open(folder / "absent.sh3f"), "absent.sh3f");

  write_archive(folder / "a.sh3f");
  auto bytes = read_file(folder / "a.sh3f");
  ASSERT_OK(bytes);
  *std::search(bytes->begin(), bytes->end(), kContent.begin(), kContent.end()) ^= 1U;
  ASSERT_OK(write_file(folder / "a.sh3f", *bytes));
  const auto archive = FurnitureArchive::open(folder / "a.sh3f");
  ASSERT_OK(archive);
  EXPECT_ERROR(archive->read("house/bed/bed.txt"), "bed.txt: damaged");
}

}  // namespace
}  // namespace roomwise::simulation
