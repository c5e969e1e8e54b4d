#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "roomwise/base/file.h"

namespace roomwise::simulation {

// The folder of a model: what it holds, and how a file of it is read.
struct ModelFolder {
  std::vector<std::string> names;
  std::function<Expected<Bytes>(const std::string& name)> read;
};

// How a model is brought to its size: its points are turned, then their bounding box is stretched
// to `size_m` along the axes, with the middle of its bottom at the origin.
struct MeshFit {
  Eigen::Matrix3d object_from_model = Eigen::Matrix3d::Identity();  // a rotation
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();
};

// Reads an OBJ with its MTL and textures (JPEG, PNG). A material whose texture is absent takes the
// only picture in the folder, else its plain colour. Normals are the file's where they make sense,
// else smooth but for creases; the corners of a triangle turn anticlockwise around them.
[[nodiscard]] Expected<TriangleMesh> load_mesh(const ModelFolder& folder,
                                               const std::string& obj_name, const MeshFit& fit);

}  // namespace roomwise::simulation
