#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::simulation {

// How a surface takes light. Colours are linear, not sRGB.
struct SurfaceMaterial {
  Eigen::Vector3f diffuse = Eigen::Vector3f::Constant(0.6F);
  std::shared_ptr<const image::ColorImage> texture;  // sRGB, multiplies diffuse; null: none
  float opacity = 1;                                 // below 1: glass, curtains
  float specular = 0;   // share of light that is mirrored at normal incidence
  float shininess = 0;  // exponent of Phong's lobe
};

// Triangles in the object frame (see PlacedObject), metres, scaled to the model's size.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;              // one a position, unit length
  std::vector<Eigen::Vector2f> texture_coordinates;  // one a position; v grows upwards
  struct Triangle {
    std::array<std::uint32_t, 3> corners;  // indices into positions
    std::uint32_t material = 0;            // index into materials
  };
  std::vector<Triangle> triangles;
  std::vector<SurfaceMaterial> materials;
};

struct FurnitureModel {
  std::string id;          // "blendswap-cc-0/bed1"
  std::string kind;        // what it is for the generator: "bed", "chair", ...
  std::string name;        // the catalogue's
  Eigen::Vector3d size_m;  // width, depth, height: x, y, z of the object frame
  double top_m = 0;        // height of the surface that things stand on; 0: nothing stands on it
  double elevation_m = 0;  // of its bottom above the floor: ceiling lamps, wall cabinets
  std::string creator;
  std::string license;
};

// The chosen models of Debian's package sweethome3d-furniture: those that networks recognise and
// that load well, listed with their kinds in furniture.txt (compiled in).
class FurnitureCatalogue {
 public:
  // Reads the .sh3f archives of a folder (default: where Debian's package puts them). Fails where
  // an archive or a listed model is missing, naming the package to install.
  [[nodiscard]] static Expected<FurnitureCatalogue> open(
      const std::filesystem::path& folder = "/usr/share/sweethome3d/furniture");

  [[nodiscard]] std::span<const FurnitureModel> models() const { return models_; }
  // Those of a kind, in the order of the list; empty where there is none.
  [[nodiscard]] std::vector<const FurnitureModel*> of_kind(std::string_view kind) const;
  [[nodiscard]] const FurnitureModel* find(std::string_view id) const;

  // Reads a model's triangles, materials and textures. May be called from many threads. Textures
  // are opaque, repeat beyond 0 to 1, and are at most 1024 px a side.
  [[nodiscard]] Expected<TriangleMesh> load(std::string_view id) const;

  // Who made the models and under which licence, one line a model: what has to be shown with
  // pictures of them. Fails for a model that is not in the catalogue.
  [[nodiscard]] Expected<std::string> credits(std::span<const std::string> ids) const;

 private:
  // Where a model's triangles are, and how they are turned before they are fitted to its size.
  struct Source {
    std::filesystem::path archive;
    std::string path;
    Eigen::Matrix3d object_from_model;
  };

  std::vector<FurnitureModel> models_;
  std::map<std::string, Source, std::less<>> sources_;  // by id
};

}  // namespace roomwise::simulation
