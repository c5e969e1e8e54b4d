#include "roomwise/mapping/cloud/pcd_file.h"

#include <gmock/gmock.h>

#include <cstring>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using ::testing::HasSubstr;

TEST(PcdFile, HoldsEveryPointAfterItsHeader) {
  const roomwise::testing::ScratchFolder folder;
  geometry::PointCloud cloud;
  cloud.add({1.5F, -2.0F, 0.25F}, {10, 20, 30});
  cloud.add({0.0F, 3.0F, 4.0F}, {255, 128, 0});
  ASSERT_OK(write_pcd(folder / "cloud.pcd", cloud));

  const auto content = read_text_file(folder / "cloud.pcd");
  ASSERT_OK(content);
  const std::string end = "DATA binary\n";
  const std::size_t body = content->find(end) + end.size();
  const std::string header = content->substr(0, body);
  EXPECT_THAT(header, HasSubstr("\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\n"));
  EXPECT_THAT(header, HasSubstr("\nWIDTH 2\nHEIGHT 1\n"));
  EXPECT_THAT(header, HasSubstr("\nPOINTS 2\n"));
  ASSERT_EQ(content->size(), body + 2 * 16);
  float second[3];
  std::memcpy(second, content->data() + body + 16, sizeof second);
  EXPECT_EQ(second[0], 0.0F);
  EXPECT_EQ(second[1], 3.0F);
  EXPECT_EQ(second[2], 4.0F);
  // As the bytes of a little-endian 0x00RRGGBB.
  EXPECT_EQ(content->substr(body + 12, 4), std::string("\x1e\x14\x0a\x00", 4));
  EXPECT_EQ(content->substr(body + 28, 4), std::string("\x00\x80\xff\x00", 4));
}

TEST(PcdFile, NamesTheFileThatCannotBeWritten) {
  const roomwise::testing::ScratchFolder folder;
  EXPECT_ERROR(write_pcd(folder / "missing" / "cloud.pcd", {}), "cloud.pcd");
}

}  // namespace
}  // namespace roomwise::mapping
