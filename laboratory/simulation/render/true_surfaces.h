#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// The surfaces of a made-up home, to measure a map against.
class TrueSurfaces {
 public:
  // Fails where a model cannot be read.
  [[nodiscard]] static Expected<TrueSurfaces> create(const HomeModel& home, const MeshLoader& load);

  // Of the home's shapes and light, as a recording's simulation.json names it.
  [[nodiscard]] const std::string& digest() const { return digest_; }
  // From a point of the world frame to the nearest surface, m; infinity where it is further than
  // `max_m`. May be called from several threads.
  [[nodiscard]] double distance_m(const Eigen::Vector3f& point_world, double max_m) const {
    return static_cast<double>(
        scene_.rays().nearest_distance(point_world, static_cast<float>(max_m)));
  }

 private:
  TrueSurfaces(Scene scene, std::string digest)
      : scene_(std::move(scene)), digest_(std::move(digest)) {}

  Scene scene_;
  std::string digest_;
};

}  // namespace roomwise::simulation
