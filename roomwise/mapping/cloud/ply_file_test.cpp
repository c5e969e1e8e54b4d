#include "roomwise/mapping/cloud/ply_file.h"

#include <gmock/gmock.h>

#include <cstring>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using ::testing::HasSubstr;

TEST(PlyFile, HoldsEveryPointAfterItsHeader) {
  const roomwise::testing::ScratchFolder folder;
  geometry::PointCloud cloud;
  cloud.add({1.5F, -2.0F, 0.25F}, {10, 20, 30});
  cloud.add({0.0F, 3.0F, 4.0F}, {255, 128, 0});
  ASSERT_OK(write_ply(folder / "cloud.ply", cloud));

  const auto content = read_text_file(folder / "cloud.ply");
  ASSERT_OK(content);
  const std::string end = "end_header\n";
  const std::size_t body = content->find(end) + end.size();
  const std::string header = content->substr(0, body);
  EXPECT_THAT(header, ::testing::StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(header, HasSubstr("element vertex 2\n"));
  ASSERT_EQ(content->size(), body + 2 * 15);

  float second[3];
  std::memcpy(second, content->data() + body + 15, sizeof second);
  EXPECT_EQ(second[0], 0.0F);
  EXPECT_EQ(second[1], 3.0F);
  EXPECT_EQ(second[2], 4.0F);
  EXPECT_EQ(content->substr(body + 12, 3), "\x0a\x14\x1e");
  EXPECT_EQ(content->substr(body + 27, 3), std::string("\xff\x80\x00", 3));
}

TEST(PlyFile, OfNoPointsIsAHeaderAlone) {
  const roomwise::testing::ScratchFolder folder;
  ASSERT_OK(write_ply(folder / "empty.ply", {}));
  const auto content = read_text_file(folder / "empty.ply");
  ASSERT_OK(content);
  EXPECT_THAT(*content, HasSubstr("element vertex 0\n"));
  EXPECT_THAT(*content, ::testing::EndsWith("end_header\n"));
}

TEST(PlyFile, NamesTheFileThatCannotBeWritten) {
  const roomwise::testing::ScratchFolder folder;
  EXPECT_ERROR(write_ply(folder / "missing" / "cloud.ply", {}), "cloud.ply");
}

}  // namespace
}  // namespace roomwise::mapping
