#include "roomwise/mapping/cloud/ply_file.h"

#include <bit>
#include <cstring>
#include <string>

#include "roomwise/base/file.h"

namespace roomwise::mapping {
namespace {

// A point as the file holds it.
constexpr std::size_t kPlyPointBytes = 3 * sizeof(float) + 3;
static_assert(std::endian::native == std::endian::little && sizeof(float) == 4);

std::string ply_header(std::size_t points) {
  return fmt::format(
      "ply\n"
      "format binary_little_endian 1.0\n"
      "comment lengths in metres\n"
      "element vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "end_header\n",
      points);
}

}  // namespace

Expected<void> write_ply(const std::filesystem::path& path, const geometry::PointCloud& cloud) {
  std::string content = ply_header(cloud.size());
  const std::size_t header_size = content.size();
  content.resize(header_size + cloud.size() * kPlyPointBytes);
  char* point = content.data() + header_size;
  for (std::size_t i = 0; i < cloud.size(); ++i, point += kPlyPointBytes) {
    const Rgb8 color = cloud.colors[i];
    std::memcpy(point, cloud.points[i].data(), 3 * sizeof(float));
    point[12] = static_cast<char>(color.r);
    point[13] = static_cast<char>(color.g);
    point[14] = static_cast<char>(color.b);
  }
  return write_file(path, content);
}

}  // namespace roomwise::mapping
