#include "laboratory/simulation/furniture/surface_materials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::simulation {
namespace {

constexpr int kLargestTexture_px = 1024;
// Nothing in a home reflects more or less; without the first light would hardly fade from bounce to
// bounce.
constexpr float kMaxDiffuse = 0.9F, kMinDiffuse = 0.02F;

float linear_of(float srgb) {
  srgb = std::clamp(srgb, 0.0F, 1.0F);
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

Eigen::Vector3f vector_of(const tinyobj::real_t (&values)[3]) {
  return {values[0], values[1], values[2]};
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](unsigned char letter) {
    return static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter);
  });
  return result;
}

bool is_picture(std::string_view name) {
  const std::string small = lower(name);
  return small.ends_with(".jpg") || small.ends_with(".jpeg") || small.ends_with(".png");
}

// The file of the folder that a material means: its path may be one of the author's machine, in
// other letters, or that of a picture that was renamed.
std::optional<std::string> find_texture(const std::string& path, const ModelFolder& folder) {
  const auto slash = path.find_last_of("/\\");
  const std::string wanted = lower(slash == std::string::npos ? path : path.substr(slash + 1));
  std::vector<std::string> pictures;
  for (const std::string& name : folder.names) {
    if (lower(name) == wanted) return name;
    if (is_picture(name)) pictures.push_back(name);
  }
  if (pictures.size() == 1) return pictures.front();
  return std::nullopt;
}

image::ColorImage shrunk(image::ColorImage texture) {
  const int longest = std::max(texture.width(), texture.height());
  if (longest <= kLargestTexture_px) return texture;
  const auto size = [&](int side) { return std::max(1, side * kLargestTexture_px / longest); };
  return image::resize(texture, size(texture.width()), size(texture.height()));
}

// Decodes every picture once, however many materials show it.
class Textures {
 public:
  explicit Textures(const ModelFolder& folder) : folder_(folder) {}

  Expected<std::shared_ptr<const image::ColorImage>> get(const std::string& path) {
    const std::optional<std::string> name = find_texture(path, folder_);
    if (!name) return nullptr;
    auto& texture = by_name_[*name];
    if (texture == nullptr) {
      ROOMWISE_TRY(const Bytes bytes, folder_.read(*name));
      auto decoded = image::decode_color(bytes);
      if (!decoded) return Unexpected(std::move(decoded).error().with_context(*name));
      texture = std::make_shared<const image::ColorImage>(shrunk(*std::move(decoded)));
    }
    return texture;
  }

 private:
  const ModelFolder& folder_;
  std::map<std::string, std::shared_ptr<const image::ColorImage>> by_name_;
};

// A texture has its colour in itself, and authors leave any brightness in Kd beside it: only the
// tint of Kd is kept.
Eigen::Vector3f tint_of(const Eigen::Vector3f& kd) {
  constexpr float kTooDarkForATint = 0.05F;
  const float brightest = kd.maxCoeff();
  if (brightest < kTooDarkForATint) return Eigen::Vector3f::Ones();
  return kd / brightest;
}

// Chrome and steel: grey, mirrored much brighter than diffuse. Black lacquer, glass and china are
// not.
bool is_metal(const tinyobj::material_t& material) {
  const Eigen::Vector3f kd = vector_of(material.diffuse);
  const float mirrored = std::clamp(vector_of(material.specular).mean(), 0.0F, 1.0F);
  const bool is_grey = kd.maxCoeff() - kd.minCoeff() < 0.15F && kd.mean() > 0.15F;
  return is_grey && mirrored > 0.65F && mirrored > 1.5F * kd.mean() && material.shininess > 30 &&
         material.dissolve >= 1 && material.diffuse_texname.empty();
}

// The share that is mirrored. Modellers leave Ks at their program's default of 0.5 for anything, so
// that it says little: varnish, plastic and china mirror some 4 %.
float specular_of(const tinyobj::material_t& material) {
  constexpr float kVarnish = 0.04F;
  constexpr float kMetal = 0.5F;
  constexpr int kNoHighlight = 1;  // of "illum"
  if (material.illum <= kNoHighlight) return 0;
  const float mirrored = std::clamp(vector_of(material.specular).mean(), 0.0F, 1.0F);
  return mirrored * (is_metal(material) ? kMetal : kVarnish);
}

SurfaceMaterial plain(const tinyobj::material_t& material) {
  SurfaceMaterial surface;
  surface.diffuse = vector_of(material.diffuse).unaryExpr(&linear_of);
  surface.opacity = std::clamp(material.dissolve, 0.0F, 1.0F);
  surface.specular = specular_of(material);
  surface.shininess = std::clamp(material.shininess, 1.0F, 1000.0F);
  return surface;
}

}  // namespace

Expected<std::vector<SurfaceMaterial>> surface_materials(
    std::span<const tinyobj::material_t> materials, const ModelFolder& folder) {
  Textures textures(folder);
  std::vector<SurfaceMaterial> surfaces;
  for (const tinyobj::material_t& material : materials) {
    SurfaceMaterial surface = plain(material);
    if (!material.diffuse_texname.empty()) {
      ROOMWISE_TRY(surface.texture, textures.get(material.diffuse_texname));
      if (surface.texture != nullptr) surface.diffuse = tint_of(surface.diffuse);
    }
    surface.diffuse = surface.diffuse.cwiseMin(kMaxDiffuse).cwiseMax(kMinDiffuse);
    surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

}  // namespace roomwise::simulation
