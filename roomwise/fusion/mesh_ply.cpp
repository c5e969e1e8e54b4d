#include <array>
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

Expected<void> write_ply(const std::filesystem::path& path, const PiecewiseMesh& mesh) {
  std::string content = header(mesh.vertex_count(), mesh.triangle_count());
  std::size_t vertex_at = content.size();
  std::size_t triangle_at = vertex_at + mesh.vertex_count() * kBytesPerVertex;
  content.resize(triangle_at + mesh.triangle_count() * kBytesPerTriangle);
  const auto put = [&](std::size_t& place, const void* bytes, std::size_t size) {
    std::memcpy(content.data() + place, bytes, size);
    place += size;
  };
  ROOMWISE_RETURN_IF_ERROR(mesh.for_each([&](const MeshPiece& piece) {
    for (std::size_t i = 0; i < piece.own; ++i) {
      put(vertex_at, piece.mesh.vertices[i].data(), 3 * sizeof(float));
      put(vertex_at, piece.mesh.normals[i].data(), 3 * sizeof(float));
      const Rgb8 color = piece.mesh.colors[i];
      const std::array<std::uint8_t, 3> channels{color.r, color.g, color.b};
      put(vertex_at, channels.data(), channels.size());
    }
    for (const auto& [a, b, c] : piece.mesh.triangles) {
      const std::uint8_t corners = 3;
      put(triangle_at, &corners, 1);
      const std::array numbers{piece.number_of(a), piece.number_of(b), piece.number_of(c)};
      put(triangle_at, numbers.data(), sizeof(numbers));
    }
  }));
  return write_file(path, content);
}

}  // namespace roomwise::fusion
