#include "laboratory/simulation/furniture/mesh_loader.h"

#include <tiny_obj_loader.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <sstream>
#include <unordered_map>

#include "laboratory/simulation/furniture/polygon_triangulation.h"
#include "laboratory/simulation/furniture/surface_materials.h"

namespace roomwise::simulation {
namespace {

// Faces that meet at a sharper angle keep an edge between them where the file has no normals.
const float kCreaseCosine = std::cos(40.0F * std::numbers::pi_v<float> / 180.0F);

std::istringstream stream_of(const Bytes& bytes) {
  return std::istringstream(std::string(bytes.begin(), bytes.end()));
}

// Gives tinyobjloader the MTL from the archive. A missing one leaves the default material.
class FolderMaterials final : public tinyobj::MaterialReader {
 public:
  explicit FolderMaterials(const ModelFolder& folder) : folder_(folder) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* by_name, std::string* warning,
                  std::string* error) override {
    const auto bytes = folder_.read(name);
    if (!bytes) return false;
    std::istringstream stream = stream_of(*bytes);
    tinyobj::LoadMtl(by_name, materials, &stream, warning, error);
    return true;
  }

 private:
  const ModelFolder& folder_;
};

struct Corner {
  std::uint32_t position = 0;
  int normal = -1, texture_coordinate = -1;  // -1: none
};
struct Face {
  std::array<Corner, 3> corners;
  int material = -1;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // of its plane, unit length
  float area = 0;                                    // twice, m^2
};

// What an OBJ holds, brought to the object frame.
struct Model {
  std::vector<Eigen::Vector3f> positions, normals;
  std::vector<Eigen::Vector2f> texture_coordinates;
  std::vector<Face> faces;
  std::vector<tinyobj::material_t> materials;
};

// False where a corner is no point of the model.
bool add_polygon(std::span<const tinyobj::index_t> indices, int material, Model& model) {
  std::vector<Eigen::Vector3f> corners;
  for (const tinyobj::index_t& index : indices) {
    if (index.vertex_index < 0 ||
        static_cast<std::size_t>(index.vertex_index) >= model.positions.size()) {
      return false;
    }
    corners.push_back(model.positions[static_cast<std::size_t>(index.vertex_index)]);
  }
  for (const auto& triangle : triangulate(corners)) {
    Face face;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const tinyobj::index_t& index = indices[triangle[corner]];
      face.corners[corner] = {static_cast<std::uint32_t>(index.vertex_index), index.normal_index,
                              index.texcoord_index};
    }
    face.material = material;
    model.faces.push_back(face);
  }
  return true;
}

// What tinyobjloader makes of an OBJ.
struct ObjFile {
  tinyobj::attrib_t numbers;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
};

Expected<ObjFile> read_obj(const Bytes& bytes, const ModelFolder& folder,
                           const std::string& obj_name, bool cut_into_triangles) {
  std::istringstream stream = stream_of(bytes);
  FolderMaterials reader(folder);
  std::string warning, error;
  ObjFile file;
  if (!tinyobj::LoadObj(&file.numbers, &file.shapes, &file.materials, &warning, &error, &stream,
                        &reader, cut_into_triangles)) {
    return fail("{}: not a model in the OBJ format: {}", obj_name, error);
  }
  return file;
}

// Whether the counts of the faces' corners are right: they end at 255.
bool counts_are_right(const tinyobj::shape_t& shape) {
  const auto& counts = shape.mesh.num_face_vertices;
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0}) == shape.mesh.indices.size();
}

Expected<Model> parse(const ModelFolder& folder, const std::string& obj_name) {
  ROOMWISE_TRY(const Bytes bytes, folder.read(obj_name));
  // tinyobjloader's own cutting leaves out parts of concave polygons, so that it is left to it only
  // where a polygon is too large to be had whole.
  ROOMWISE_TRY(ObjFile file, read_obj(bytes, folder, obj_name, false));
  if (!std::ranges::all_of(file.shapes, counts_are_right)) {
    ROOMWISE_TRY(file, read_obj(bytes, folder, obj_name, true));
  }
  Model model;
  model.materials = std::move(file.materials);
  const tinyobj::attrib_t& numbers = file.numbers;
  for (std::size_t i = 0; i + 2 < numbers.vertices.size(); i += 3) {
    model.positions.emplace_back(numbers.vertices[i], numbers.vertices[i + 1],
                                 numbers.vertices[i + 2]);
  }
  for (std::size_t i = 0; i + 2 < numbers.normals.size(); i += 3) {
    model.normals.emplace_back(numbers.normals[i], numbers.normals[i + 1], numbers.normals[i + 2]);
  }
  for (std::size_t i = 0; i + 1 < numbers.texcoords.size(); i += 2) {
    model.texture_coordinates.emplace_back(numbers.texcoords[i], numbers.texcoords[i + 1]);
  }
  for (const tinyobj::shape_t& shape : file.shapes) {
    std::span<const tinyobj::index_t> left(shape.mesh.indices);
    for (std::size_t i = 0; i < shape.mesh.num_face_vertices.size(); ++i) {
      const std::size_t corners = shape.mesh.num_face_vertices[i];
      if (!add_polygon(left.first(corners), shape.mesh.material_ids[i], model)) {
        return fail("{}: a face names a point that the file does not hold", obj_name);
      }
      left = left.subspan(corners);
    }
  }
  return model;
}

// Brings points and normals to the object frame. Fails for a model without extent along an axis
// unless the fit is thin there too.
Expected<void> fit_model(Model& model, const MeshFit& fit) {
  const Eigen::Matrix3f turn = fit.object_from_model.cast<float>();
  Eigen::AlignedBox3f box;
  for (Face& face : model.faces) {
    for (const Corner& corner : face.corners) box.extend(turn * model.positions[corner.position]);
  }
  if (box.isEmpty() || !box.sizes().allFinite()) return fail("the model has no faces");
  Eigen::Vector3f scale;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = box.sizes()[axis];
    scale[axis] = extent > 0 ? static_cast<float>(fit.size_m[axis]) / extent : 1.0F;
  }
  const Eigen::Vector3f base(box.center().x(), box.center().y(), box.min().z());
  for (Eigen::Vector3f& position : model.positions) {
    position = scale.cwiseProduct(turn * position - base);
  }
  for (Eigen::Vector3f& normal : model.normals) {
    normal = (turn * normal).cwiseQuotient(scale).stableNormalized();
  }
  return {};
}

// Finds the planes of the faces and leaves out those without area.
void measure_faces(Model& model) {
  for (Face& face : model.faces) {
    const Eigen::Vector3f& a = model.positions[face.corners[0].position];
    const Eigen::Vector3f cross = (model.positions[face.corners[1].position] - a)
                                      .cross(model.positions[face.corners[2].position] - a);
    face.area = cross.stableNorm();
    if (face.area > 0) face.normal = cross.stableNormalized();
  }
  std::erase_if(model.faces, [](const Face& face) { return !(face.area > 0); });
}

// The file's normal at a corner; null where it has none that makes sense.
const Eigen::Vector3f* file_normal(const Model& model, const Corner& corner) {
  if (corner.normal < 0 || static_cast<std::size_t>(corner.normal) >= model.normals.size()) {
    return nullptr;
  }
  const Eigen::Vector3f& normal = model.normals[static_cast<std::size_t>(corner.normal)];
  return std::abs(normal.norm() - 1) < 1e-3F ? &normal : nullptr;
}

// Some exporters turn the corners of faces the other way round than their normals say; the normals
// are what the modeller saw.
void turn_faces_to_their_normals(Model& model) {
  for (Face& face : model.faces) {
    float agreement = 0;
    for (const Corner& corner : face.corners) {
      if (const auto* normal = file_normal(model, corner)) agreement += normal->dot(face.normal);
    }
    if (agreement >= 0) continue;
    std::swap(face.corners[1], face.corners[2]);
    face.normal = -face.normal;
  }
}

// Which faces meet at each position, as one list after another.
class FacesAtPositions {
 public:
  explicit FacesAtPositions(const Model& model) : first_(model.positions.size() + 1, 0) {
    for (const Face& face : model.faces) {
      for (const Corner& corner : face.corners) ++first_[corner.position + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    faces_.resize(first_.back());
    std::vector<std::size_t> next = first_;
    for (const Face& face : model.faces) {
      for (const Corner& corner : face.corners) faces_[next[corner.position]++] = &face;
    }
  }

  [[nodiscard]] std::span<const Face* const> at(std::uint32_t position) const {
    return std::span(faces_).subspan(first_[position], first_[position + 1] - first_[position]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<const Face*> faces_;
};

Eigen::Vector3f smooth_normal(const Face& face, std::span<const Face* const> neighbours) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Face* neighbour : neighbours) {
    if (neighbour->normal.dot(face.normal) > kCreaseCosine) {
      sum += neighbour->area * neighbour->normal;
    }
  }
  // The face is among its neighbours, and all lie within a cone, so that the sum is not zero.
  return sum.stableNormalized();
}

// Joins corners that agree in everything to one vertex.
class VertexMaker {
 public:
  explicit VertexMaker(TriangleMesh& mesh) : mesh_(mesh) {}

  std::uint32_t add(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                    const Eigen::Vector2f& texture_coordinate) {
    const Key key{position.x(), position.y(), position.z(),           normal.x(),
                  normal.y(),   normal.z(),   texture_coordinate.x(), texture_coordinate.y()};
    const auto [found, is_new] =
        vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(position);
      mesh_.normals.push_back(normal);
      mesh_.texture_coordinates.push_back(texture_coordinate);
    }
    return found->second;
  }

 private:
  using Key = std::array<float, 8>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t hash = 0xCBF29CE484222325U;  // FNV-1a over the words
      for (const float number : key) {
        // Zeros of both signs are equal, so their hashes must be.
        hash = (hash ^ std::bit_cast<std::uint32_t>(number + 0.0F)) * 0x100000001B3U;
      }
      return hash ^ (hash >> 32U);
    }
  };

  TriangleMesh& mesh_;
  std::unordered_map<Key, std::uint32_t, Hash> vertices_;
};

Eigen::Vector2f texture_coordinate_of(const Model& model, const Corner& corner) {
  const auto index = static_cast<std::size_t>(corner.texture_coordinate);
  if (corner.texture_coordinate < 0 || index >= model.texture_coordinates.size() ||
      !model.texture_coordinates[index].allFinite()) {
    return Eigen::Vector2f::Zero();
  }
  return model.texture_coordinates[index];
}

TriangleMesh mesh_of(const Model& model, std::vector<SurfaceMaterial> materials) {
  TriangleMesh mesh;
  mesh.materials = std::move(materials);
  mesh.materials.emplace_back();  // of faces that name none
  const auto no_material = static_cast<std::uint32_t>(mesh.materials.size() - 1);
  VertexMaker vertices(mesh);
  const FacesAtPositions neighbours(model);
  for (const Face& face : model.faces) {
    TriangleMesh::Triangle triangle;
    triangle.material = std::min(
        face.material < 0 ? no_material : static_cast<std::uint32_t>(face.material), no_material);
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner& corner = face.corners[i];
      const Eigen::Vector3f* normal = file_normal(model, corner);
      // One that looks away from its own face is broken.
      const bool is_usable = normal != nullptr && normal->dot(face.normal) > 0;
      triangle.corners[i] =
          vertices.add(model.positions[corner.position],
                       is_usable ? *normal : smooth_normal(face, neighbours.at(corner.position)),
                       texture_coordinate_of(model, corner));
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

Expected<TriangleMesh> load_mesh(const ModelFolder& folder, const std::string& obj_name,
                                 const MeshFit& fit) {
  ROOMWISE_TRY(Model model, parse(folder, obj_name));
  if (auto fitted = fit_model(model, fit); !fitted) {
    return Unexpected(std::move(fitted).error().with_context(obj_name));
  }
  measure_faces(model);
  turn_faces_to_their_normals(model);
  ROOMWISE_TRY(auto materials, surface_materials(model.materials, folder));
  return mesh_of(model, std::move(materials));
}

}  // namespace roomwise::simulation
