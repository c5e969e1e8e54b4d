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
  // `bytes` is a multiple of four long, so that all views are aligned.
  Json& add(const void* bytes, std::size_t size, int target, int component, std::size_t count,
            const char* type) {
    views.push_back(
        {{"buffer", 0}, {"byteOffset", content.size()}, {"byteLength", size}, {"target", target}});
    content.append(static_cast<const char*>(bytes), size);
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", count},
                         {"type", type}});
    return accessors.back();
  }

  std::string content;
  Json views = Json::array(), accessors = Json::array();
};

void add_vertices(Buffer& buffer, const TriangleMesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  std::vector<Vector3f> vectors;
  vectors.reserve(count);
  Vector3f least = Vector3f::Constant(std::numeric_limits<float>::infinity()), most = -least;
  for (const Vector3f& vertex : mesh.vertices) {
    vectors.push_back(y_up(vertex));
    least = least.cwiseMin(vectors.back());
    most = most.cwiseMax(vectors.back());
  }
  const std::size_t size = count * 3 * sizeof(float);
  Json& positions = buffer.add(vectors.data(), size, kVertexTarget, kFloat, count, "VEC3");
  positions["min"] = Json::array({least.x(), least.y(), least.z()});
  positions["max"] = Json::array({most.x(), most.y(), most.z()});

  for (std::size_t i = 0; i < count; ++i) vectors[i] = y_up(mesh.normals[i]);
  buffer.add(vectors.data(), size, kVertexTarget, kFloat, count, "VEC3");

  static const std::array<std::uint16_t, 256> kLinear = make_linear_of_srgb();
  std::vector<std::array<std::uint16_t, 4>> colors;
  colors.reserve(count);
  for (const Rgb8 color : mesh.colors) {
    colors.push_back({kLinear[color.r], kLinear[color.g], kLinear[color.b], 65535});
  }
  buffer.add(colors.data(), count * sizeof(colors[0]), kVertexTarget, kUnsignedShort, count,
             "VEC4")["normalized"] = true;
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

Expected<void> write_glb(const std::filesystem::path& path, const TriangleMesh& mesh_gravity) {
  if (mesh_gravity.triangles.empty()) {
    return fail("{}: the map has no surface; glTF cannot hold an empty mesh", path.string());
  }
  Buffer buffer;
  add_vertices(buffer, mesh_gravity);
  buffer.add(mesh_gravity.triangles.data(),
             mesh_gravity.triangles.size() * 3 * sizeof(std::uint32_t), kIndexTarget, kUnsignedInt,
             3 * mesh_gravity.triangles.size(), "SCALAR");
  std::string json = describe(buffer).dump();
  json.append((4 - json.size() % 4) % 4, ' ');
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const std::size_t size = kHeader + 2 * kChunkHeader + json.size() + buffer.content.size();
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    return fail("{}: the mesh takes {} bytes, and a .glb file holds 4 GiB; take larger voxels",
                path.string(), size);
  }
  std::string file;
  file.reserve(size);
  append_number(file, kMagic);
  append_number(file, 2);
  append_number(file, size);
  append_number(file, json.size());
  append_number(file, kJsonChunk);
  file += json;
  append_number(file, buffer.content.size());
  append_number(file, kBinaryChunk);
  file += buffer.content;
  return write_file(path, file);
}

}  // namespace roomwise::fusion
