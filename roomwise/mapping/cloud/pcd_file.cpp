#include "roomwise/mapping/cloud/pcd_file.h"

#include <bit>
#include <cstring>
#include <string>

#include "roomwise/base/file.h"

namespace roomwise::mapping {
namespace {

constexpr std::size_t kPcdPointBytes = 4 * sizeof(float);
static_assert(std::endian::native == std::endian::little && sizeof(float) == 4);

std::string pcd_header(std::size_t points) {
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "VERSION 0.7\n"
      "FIELDS x y z rgb\n"
      "SIZE 4 4 4 4\n"
      "TYPE F F F F\n"
      "COUNT 1 1 1 1\n"
      "WIDTH {0}\n"
      "HEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\n"
      "POINTS {0}\n"
      "DATA binary\n",
      points);
}

}  // namespace

Expected<void> write_pcd(const std::filesystem::path& path, const geometry::PointCloud& cloud) {
  std::string content = pcd_header(cloud.size());
  std::size_t place = content.size();
  content.resize(place + cloud.size() * kPcdPointBytes);
  for (std::size_t i = 0; i < cloud.size(); ++i, place += kPcdPointBytes) {
    const Rgb8 color = cloud.colors[i];
    const std::uint32_t packed = static_cast<std::uint32_t>(color.r) << 16 |
                                 static_cast<std::uint32_t>(color.g) << 8 | color.b;
    std::memcpy(content.data() + place, cloud.points[i].data(), 3 * sizeof(float));
    std::memcpy(content.data() + place + 3 * sizeof(float), &packed, sizeof(packed));
  }
  return write_file(path, content);
}

}  // namespace roomwise::mapping
