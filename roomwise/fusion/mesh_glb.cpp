#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "roomwise/base/file.h"
#include "roomwise/fusion/mesh_files.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3f;
using Json = nlohmann::ordered_json;
static_assert(std::endian::native == std::endian::little && sizeof(float) == 4);

// Numbers of the specification.
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

Vector3f y_up(const Vector3f& level) {
  return {level.x(), level.z(), -level.y()};
}

// Vertex colours of glTF are linear: an sRGB value as light (IEC 61966-2-1), 0 to 65535.
std::array<std::uint16_t, 256> make_linear_of_srgb() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    const double light = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    table[i] = static_cast<std::uint16_t>(std::lround(65535 * light));
  }
  return table;
}

// The binary chunk and what the JSON says of it: a view and an accessor for each array.
class Buffer {
 public:
  // Of as many values as `fill` appends to the content; together a multiple of four bytes, so that
  // all views are aligned.
  template <typename Fill>
  [[nodiscard]] Expected<Json*> add(int target, int component, std::size_t count, const char* type,
                                    const Fill& fill) {
    const std::size_t offset = content.size();
    ROOMWISE_RETURN_IF_ERROR(fill());
    views.push_back({{"buffer", 0},
                     {"byteOffset", offset},
                     {"byteLength", content.size() - offset},
                     {"target", target}});
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", count},
                         {"type", type}});
    return &accessors.back();
  }
  template <typename Value>
  void append(const Value& value) {
    content.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }

  std::string content;
  Json views = Json::array(), accessors = Json::array();
};

Expected<void> add_vertices(Buffer& buffer, const PiecewiseMesh& mesh) {
  const std::size_t count = mesh.vertex_count();
  Vector3f least = Vector3f::Constant(std::numeric_limits<float>::infinity()), most = -least;
  const auto add_positions = [&] {
    return mesh.for_each([&](const MeshPiece& piece) {
      for (const Vector3f& vertex : piece.own_vertices()) {
        const Vector3f position = y_up(vertex);
        least = least.cwiseMin(position);
        most = most.cwiseMax(position);
        buffer.append(position);
      }
    });
  };
  ROOMWISE_TRY(Json* const positions,
               buffer.add(kVertexTarget, kFloat, count, "VEC3", add_positions));
  (*positions)["min"] = Json::array({least.x(), least.y(), least.z()});
  (*positions)["max"] = Json::array({most.x(), most.y(), most.z()});

  const auto add_normals = [&] {
    return mesh.for_each([&](const MeshPiece& piece) {
      for (std::size_t i = 0; i < piece.own; ++i) buffer.append(y_up(piece.mesh.normals[i]));
    });
  };
  ROOMWISE_RETURN_IF_ERROR(buffer.add(kVertexTarget, kFloat, count, "VEC3", add_normals));

  static const std::array<std::uint16_t, 256> kLinear = make_linear_of_srgb();
  const auto add_colors = [&] {
    return mesh.for_each([&](const MeshPiece& piece) {
      for (std::size_t i = 0; i < piece.own; ++i) {
        const Rgb8 color = piece.mesh.colors[i];
        buffer.append(std::array<std::uint16_t, 4>{kLinear[color.r], kLinear[color.g],
                                                   kLinear[color.b], 65535});
      }
    });
  };
  ROOMWISE_TRY(Json* const colors,
               buffer.add(kVertexTarget, kUnsignedShort, count, "VEC4", add_colors));
  (*colors)["normalized"] = true;
  return {};
}

Expected<void> add_triangles(Buffer& buffer, const PiecewiseMesh& mesh) {
  const auto add_indices = [&] {
    return mesh.for_each([&](const MeshPiece& piece) {
      for (const auto& triangle : piece.mesh.triangles) {
        for (const std::uint32_t corner : triangle) buffer.append(piece.number_of(corner));
      }
    });
  };
  ROOMWISE_RETURN_IF_ERROR(
      buffer.add(kIndexTarget, kUnsignedInt, 3 * mesh.triangle_count(), "SCALAR", add_indices));
  return {};
}

Json describe(const Buffer& buffer) {
  const Json attributes = {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}};
  const Json primitive = {{"attributes", attributes}, {"indices", 3}, {"material", 0}};
  const Json mesh = {{"primitives", Json::array({primitive})}};
  const Json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                         {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
  const Json node = {{"mesh", 0}, {"name", "home"}};
  const Json scene = {{"nodes", Json::array({0})}};
  const Json whole_buffer = {{"byteLength", buffer.content.size()}};
  return {{"asset", {{"version", "2.0"}, {"generator", "Roomwise"}}},
          {"extensionsUsed", Json::array({"KHR_materials_unlit"})},
          {"scene", 0},
          {"scenes", Json::array({scene})},
          {"nodes", Json::array({node})},
          {"meshes", Json::array({mesh})},
          {"materials", Json::array({material})},
          {"buffers", Json::array({whole_buffer})},
          {"bufferViews", buffer.views},
          {"accessors", buffer.accessors}};
}

void append_number(std::string& file, std::size_t number) {
  const auto value = static_cast<std::uint32_t>(number);
  file.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

Expected<void> write_glb(const std::filesystem::path& path, const PiecewiseMesh& mesh_gravity) {
  if (mesh_gravity.triangle_count() == 0) {
    return fail("{}: the map has no surface; glTF cannot hold an empty mesh", path.string());
  }
  constexpr std::size_t kBytesPerVertex = 32, kBytesPerTriangle = 12;
  const std::size_t bytes = kBytesPerVertex * mesh_gravity.vertex_count() +
                            kBytesPerTriangle * mesh_gravity.triangle_count();
  Buffer buffer;
  constexpr std::size_t kHead = 4096;  // the file's own, about
  buffer.content.reserve(bytes + kHead);
  ROOMWISE_RETURN_IF_ERROR(add_vertices(buffer, mesh_gravity));
  ROOMWISE_RETURN_IF_ERROR(add_triangles(buffer, mesh_gravity));
  std::string json = describe(buffer).dump();
  json.append((4 - json.size() % 4) % 4, ' ');
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const std::size_t size = kHeader + 2 * kChunkHeader + json.size() + buffer.content.size();
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    return fail("{}: the mesh takes {} bytes, and a .glb file holds 4 GiB; take larger voxels",
                path.string(), size);
  }
  std::string head;
  append_number(head, kMagic);
  append_number(head, 2);
  append_number(head, size);
  append_number(head, json.size());
  append_number(head, kJsonChunk);
  head += json;
  append_number(head, buffer.content.size());
  append_number(head, kBinaryChunk);
  buffer.content.insert(0, head);
  return write_file(path, buffer.content);
}

}  // namespace roomwise::fusion
