#include "laboratory/simulation/render/light_cache.h"

#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <type_traits>

#include "roomwise/base/file.h"

namespace roomwise::simulation {
namespace {

// To be changed whenever the bake gives other light for the same scene.
constexpr std::string_view kFormat = "roomwise baked light 3\n";
constexpr std::size_t kDigestLength = 64;

template <typename Value>
requires(std::is_arithmetic_v<Value> || std::is_enum_v<Value>) void append(Bytes& bytes,
                                                                           const Value& value) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), data, data + sizeof(Value));
}

void append(Bytes& bytes, const Eigen::Vector3f& vector) {
  for (const float value : vector) append(bytes, value);
}

void append(Bytes& bytes, std::string_view text) {
  for (const char letter : text) bytes.push_back(static_cast<std::uint8_t>(letter));
}

void append(Bytes& bytes, const std::vector<Eigen::Vector3f>& vectors) {
  for (const Eigen::Vector3f& vector : vectors) append(bytes, vector);
}

void append_triangle(Bytes& bytes, const Scene& scene, const SceneTriangle& triangle) {
  for (const std::uint32_t corner : triangle.corners) append(bytes, corner);
  append(bytes, triangle.patch);
  append(bytes, triangle.object);
  const Appearance& appearance = scene.appearances()[triangle.appearance];
  append(bytes, appearance.opacity());
  append(bytes, appearance.mean_albedo(0.1F));
  append(bytes, appearance.mean_albedo(1.2F));
}

void append_outside(Bytes& bytes, const Outside& outside) {
  append(bytes, outside.sun_illuminance());
  append(bytes, outside.sun_direction());
  for (const float height : {-0.9F, 0.0F, 0.1F, 0.3F, 0.7F, 1.0F}) {
    append(bytes, outside.mean_radiance({std::sqrt(1 - height * height), 0, height}));
  }
}

}  // namespace

std::string scene_digest(const Scene& scene, const Emitters& emitters) {
  Bytes bytes;
  append(bytes, scene.positions());
  append(bytes, scene.normals());
  append(bytes, scene.opaque_count());
  for (const SceneTriangle& triangle : scene.triangles()) {
    append_triangle(bytes, scene, triangle);
  }
  for (const Emitter& emitter : emitters.all()) {
    append(bytes, emitter.kind);
    for (const Eigen::Vector3f& vector :
         {emitter.center, emitter.u, emitter.v, emitter.normal, emitter.strength}) {
      append(bytes, vector);
    }
    append(bytes, emitter.radius_m);
    append(bytes, emitter.object);
    append(bytes, emitter.room);
  }
  append_outside(bytes, scene.outside());
  return sha256_hex(bytes);
}

std::string light_key(const std::string& scene_digest, double effort) {
  Bytes bytes;
  append(bytes, kFormat);
  append(bytes, effort);
  append(bytes, scene_digest);
  return sha256_hex(bytes);
}

// The file: the format's line, the key, the digest of the rest, the rest.
std::optional<BakedLight> read_light(const std::filesystem::path& path, const std::string& key,
                                     const Scene& scene) {
  const auto bytes = read_file(path);
  if (!bytes) return std::nullopt;
  const std::string head = std::string(kFormat) + key;
  const std::size_t corners = scene.positions().size();
  const std::size_t payload_size = (scene.texel_count() + 2 * corners) * 3 * sizeof(float);
  if (bytes->size() != head.size() + kDigestLength + payload_size) return std::nullopt;
  if (std::memcmp(bytes->data(), head.data(), head.size()) != 0) return std::nullopt;
  const std::span payload = std::span(*bytes).subspan(head.size() + kDigestLength);
  const std::string digest(bytes->begin() + static_cast<std::ptrdiff_t>(head.size()),
                           bytes->end() - static_cast<std::ptrdiff_t>(payload_size));
  if (sha256_hex(payload) != digest) return std::nullopt;

  const std::uint8_t* from = payload.data();
  const auto take = [&](std::vector<Eigen::Vector3f>& vectors, std::size_t count) {
    vectors.resize(count);
    for (Eigen::Vector3f& vector : vectors) {
      std::memcpy(vector.data(), from, 3 * sizeof(float));
      from += 3 * sizeof(float);
    }
  };
  BakedLight light;
  take(light.texels, scene.texel_count());
  take(light.corners[0], corners);
  take(light.corners[1], corners);
  return light;
}

Expected<void> write_light(const std::filesystem::path& path, const std::string& key,
                           const BakedLight& light) {
  Bytes payload;
  append(payload, light.texels);
  append(payload, light.corners[0]);
  append(payload, light.corners[1]);
  Bytes file;
  append(file, kFormat);
  append(file, key);
  append(file, sha256_hex(payload));
  file.insert(file.end(), payload.begin(), payload.end());
  return write_file(path, file);
}

}  // namespace roomwise::simulation
