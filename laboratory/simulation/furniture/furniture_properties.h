#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// What the property file of a furniture archive (PluginFurnitureCatalog.properties) says of a
// model. Its axes: x to the right, y up, z towards the front.
struct FurnitureProperties {
  std::string id;          // the folder of its model: "blendswap-cc-0/bed1"
  std::string model_path;  // in the archive: "blendswap-cc-0/bed1/bed1.obj"
  std::string name;
  std::string creator;
  std::string license;                               // of the archive
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // width, depth, height
  double elevation_m = 0;  // of its bottom above the floor: ceiling lamps, wall cabinets
  double top_m = 0;        // where things are put down on it; 0: nowhere
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the model, before it is scaled
};

// Reads the property file's text (ISO 8859-1 with \uXXXX, as Java writes it). Fails, naming the
// property, where a model lacks a value or a value makes no sense.
[[nodiscard]] Expected<std::vector<FurnitureProperties>> parse_furniture_properties(
    std::string_view text);

}  // namespace roomwise::simulation
