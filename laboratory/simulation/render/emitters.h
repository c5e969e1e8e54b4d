#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/scene/scene.h"

namespace roomwise::simulation {

// The light that passes or meets a point: for each colour (column) the sum of the directions it
// comes from, weighted by its illuminance on a surface that faces it. The illuminance on a surface
// of normal n is about n^T flux, for n near the one that it was gathered for.
using Flux = Eigen::Matrix3f;

// What sends direct light.
struct Emitter {
  enum class Kind { kWindow, kPanel, kLamp };
  Kind kind = Kind::kLamp;
  Eigen::Vector3f center;
  Eigen::Vector3f u = Eigen::Vector3f::Zero(), v = Eigen::Vector3f::Zero();  // half edges
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    // where a window or a panel shines to
  Eigen::Vector3f strength = Eigen::Vector3f::Zero();  // radiance of a panel, intensity of a lamp
  float radius_m = 0;                                  // of a lamp
  std::uint16_t object = 0;  // 1 + index of the piece of furniture it sits in; 0: none
  std::size_t room = 0;
};

// A spot that the sun lights: from it the sun's light goes on into the room.
struct SunSpot {
  Eigen::Vector3f position, normal;
  Eigen::Vector3f intensity;  // along the normal
};

// The home's direct light: windows, panels, lamps, the sun; and the first bounce of the sun's,
// whose small bright spots rays at random would seldom find.
class Emitters {
 public:
  Emitters(const HomeModel& home, const Scene& scene, double effort);

  // Light from the emitters that can matter at a point: those of its room and of rooms that an
  // opening joins to it. `seed` shifts the pattern of samples; rays is increased by those traced.
  [[nodiscard]] Flux flux(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                          std::uint32_t seed, std::uint64_t& rays) const;
  // The sun's light after its first bounce.
  [[nodiscard]] Flux sun_bounce(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                                std::uint32_t seed, std::uint64_t& rays) const;
  // The sun's own light on a surface, averaged over its disc.
  [[nodiscard]] Eigen::Vector3f sun(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                                    std::uint32_t seed, std::uint64_t& rays) const;
  [[nodiscard]] const std::vector<Emitter>& all() const { return emitters_; }

 private:
  struct Area {  // of a room, grown by half the walls
    Rectangle rectangle;
    float from_m, to_m;  // heights
    std::vector<std::size_t> emitters, sun_rooms;
  };
  // Calls visit(room) for the rooms that a point lies in or between.
  template <typename Visit>
  void visit_areas(const Eigen::Vector3f& point, const Visit& visit) const;
  void add_windows();
  void add_lights(const HomeModel& home);
  void add_sun_spots(std::size_t room_count);
  void join_rooms(const HomeModel& home);
  [[nodiscard]] float expected(const Emitter& emitter, const Eigen::Vector3f& point,
                               const Eigen::Vector3f& normal) const;
  [[nodiscard]] Flux sample(const Emitter& emitter, const Eigen::Vector3f& point,
                            const Eigen::Vector3f& normal, int count, std::uint32_t seed,
                            std::uint64_t& rays) const;
  [[nodiscard]] Flux sample_spots(const std::vector<SunSpot>& spots, const Eigen::Vector3f& point,
                                  const Eigen::Vector3f& normal, std::uint32_t seed,
                                  std::uint64_t& rays) const;
  [[nodiscard]] float lamp_light_left(const Emitter& lamp, const Eigen::Vector3f& point,
                                      const Eigen::Vector3f& towards, std::uint64_t& rays) const;

  const Scene& scene_;
  int samples_;
  std::vector<Emitter> emitters_;
  std::vector<std::vector<SunSpot>> sun_spots_;  // by room
  std::vector<Area> areas_;                      // by room
};

}  // namespace roomwise::simulation
