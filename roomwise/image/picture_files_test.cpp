#include "roomwise/image/picture_files.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::image {
namespace {

TEST(PictureFiles, AreThoseThatEndSoInAllFolders) {
  const roomwise::testing::ScratchFolder folder;
  std::filesystem::create_directories(folder / "b/c");
  std::filesystem::create_directories(folder / "folder.png");
  for (const char* name : {"b/c/1.JPG", "a.jpeg", "b/2.png", "b/notes.txt", "jpg"})
    ASSERT_OK(write_file(folder / name, "any"));
  std::filesystem::create_symlink("gone.jpg", folder / "link.jpg");
  const auto files = picture_files(folder.path());
  ASSERT_OK(files);
  EXPECT_THAT(*files,
              ::testing::ElementsAre(folder / "a.jpeg", folder / "b/2.png", folder / "b/c/1.JPG"));
  EXPECT_ERROR(picture_files(folder / "none"), "none: cannot be read");
}

}  // namespace
}  // namespace roomwise::image
