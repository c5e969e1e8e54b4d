#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/light_points.h"

namespace roomwise::simulation {

// The light that was gathered at CornerPoints with its noise averaged away, and blended from them
// to the corners of triangles. Ranges of points may be worked on at once.
class CornerLight {
 public:
  // Direct light has the edges of shadows and takes less smoothing than bounced light does.
  CornerLight(const CornerPoints& points, std::span<const Flux> direct,
              std::span<const Flux> bounced);

  // Every round is to be carried out for all points before the next, always by the same ranges,
  // each of which begins at a multiple of kChunk and holds no more than that.
  static constexpr int kRounds = 3;
  static constexpr std::size_t kChunk = 512;
  void smooth(int round, std::size_t from, std::size_t to);

  // After the last round: the illuminance of corners, front and back.
  void blend(std::size_t from, std::size_t to,
             std::array<std::vector<Eigen::Vector3f>, 2>& light) const;

 private:
  // A flux whose fourth row is its luminance: four numbers at a time, and one to compare by.
  using Light = Eigen::Matrix<float, 4, 3>;
  // Which points tell of those of a chunk is found in the first round and kept for the others.
  struct Neighborhood {
    std::vector<LightPointIndex::Neighbor> neighbors;
    std::array<std::uint32_t, kChunk + 1> first{};  // of each point, and the end
  };
  static Light light_of(const Flux& flux);
  static Eigen::Vector4f met_by(const Light& light, const Eigen::Vector3f& normal);
  [[nodiscard]] Neighborhood neighborhood_of(std::size_t from, std::size_t to) const;
  [[nodiscard]] Light smoothed(const std::vector<Light>& lights, std::size_t point,
                               std::span<const LightPointIndex::Neighbor> neighbors,
                               float tolerance) const;

  const CornerPoints& points_;
  // A round reads one of each pair and writes the other.
  std::array<std::vector<Light>, 2> direct_, bounced_;
  std::vector<bool> is_dark_;
  std::vector<Neighborhood> neighborhoods_;
};

}  // namespace roomwise::simulation
