#include <bit>
#include <cstring>
#include <string>

#include "roomwise/base/file.h"
#include "roomwise/fusion/mesh_files.h"

namespace roomwise::fusion {
namespace {

constexpr std::size_t kBytesPerVertex = 6 * sizeof(float) + 3;
constexpr std::size_t kBytesPerTriangle = 1 + 3 * sizeof(std::int32_t);
static_assert(std::endian::native == std::endian::little && sizeof(float) == 4);

std::string header(std::size_t vertices, std::size_t triangles) {
  return fmt::format(
      "ply\n"
      "format binary_little_endian 1.0\n"
      "comment lengths in metres\n"
      "element vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\n"
      "property list uchar int vertex_indices\n"
      "end_header\n",
      vertices, triangles);
}

}  // namespace

Expected<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::string content = header(mesh.vertices.size(), mesh.triangles.size());
  std::size_t place = content.size();
  content.resize(place + mesh.vertices.size() * kBytesPerVertex +
                 mesh.triangles.size() * kBytesPerTriangle);
  const auto put = [&](const void* bytes, std::size_t size) {
    std::memcpy(content.data() + place, bytes, size);
    place += size;
  };
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    put(mesh.vertices[i].data(), 3 * sizeof(float));
    put(mesh.normals[i].data(), 3 * sizeof(float));
    const std::array<std::uint8_t, 3> color{mesh.colors[i].r, mesh.colors[i].g, mesh.colors[i].b};
    put(color.data(), color.size());
  }
  for (const auto& triangle : mesh.triangles) {
    const std::uint8_t corners = 3;
    put(&corners, 1);
    put(triangle.data(), 3 * sizeof(std::int32_t));
  }
  return write_file(path, content);
}

}  // namespace roomwise::fusion
