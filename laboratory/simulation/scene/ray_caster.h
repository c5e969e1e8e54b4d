#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// What a ray meets first.
struct RayHit {
  float distance = 0;  // in lengths of the ray's direction
  float u = 0, v = 0;  // weights of the triangle's second and third corner
  std::uint32_t triangle = 0;
};

// Rays against triangles, by Embree. The triangles that let light through are told from the others,
// so that light can pass them. One thread builds, so that two builds give the same bits.
class RayCaster {
 public:
  using Corners = std::array<std::uint32_t, 3>;

  // Hits number the opaque triangles first, then the clear ones.
  [[nodiscard]] static Expected<std::unique_ptr<RayCaster>> build(
      std::span<const Eigen::Vector3f> positions, std::span<const Corners> opaque,
      std::span<const Corners> clear);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  enum class Meets { kEverything, kOpaque };

  // The first triangle between `nearest` and `farthest` (in lengths of the direction).
  [[nodiscard]] std::optional<RayHit> first_hit(const Eigen::Vector3f& origin,
                                                const Eigen::Vector3f& direction, float nearest,
                                                float farthest, Meets meets) const;
  // Rays from one place that go about the same way: traced together they take a third of the time.
  // (Rays all around do not gain by it.)
  static constexpr std::size_t kBundle = 16;
  struct Bundle {
    std::array<Eigen::Vector3f, kBundle> directions;
    std::array<float, kBundle> farthest;  // in lengths of the direction
    std::size_t count = 0;

    void add(const Eigen::Vector3f& direction, float farthest_in_lengths) {
      directions[count] = direction;
      farthest[count] = farthest_in_lengths;
      ++count;
    }
  };
  // What the rays of a bundle meet first.
  [[nodiscard]] std::array<std::optional<RayHit>, kBundle> first_hits(const Eigen::Vector3f& origin,
                                                                      const Bundle& bundle) const;
  // Whether an opaque triangle lies between `nearest` and `farthest`.
  [[nodiscard]] bool is_blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                float nearest, float farthest) const;
  // To the nearest point of any triangle; infinity where it is further than `most`.
  [[nodiscard]] float nearest_distance(const Eigen::Vector3f& point, float most) const;
  [[nodiscard]] bool has_clear_triangles() const { return has_clear_; }

 private:
  struct Handles;
  RayCaster(std::unique_ptr<Handles> handles, std::uint32_t opaque_count, bool has_clear);

  std::unique_ptr<Handles> handles_;
  std::uint32_t opaque_count_;
  bool has_clear_;
};

}  // namespace roomwise::simulation
