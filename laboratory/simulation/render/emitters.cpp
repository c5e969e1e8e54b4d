#include "laboratory/simulation/render/emitters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/sampling.h"

namespace roomwise::simulation {
namespace {

constexpr float kSunRadius = 0.0047F;  // of its disc, rad
constexpr float kShadeTransmission = 0.35F;
constexpr float kShadeReach = 0.14F;  // a lamp's shade begins this far below its light
constexpr int kSpotsPerWindow = 512;
constexpr float kNearestSpot = 0.15F;  // nearer spots count as if this far: no bright specks

void add_light(Flux& flux, const Eigen::Vector3f& direction, const Eigen::Vector3f& light) {
  flux += direction * light.transpose();
}

}  // namespace

Emitters::Emitters(const HomeModel& home, const Scene& scene, double effort)
    : scene_(scene), samples_(std::max(4, static_cast<int>(std::lround(32 * effort)))) {
  add_windows();
  add_lights(home);
  add_sun_spots(home.rooms.size());
  join_rooms(home);
}

void Emitters::add_windows() {
  for (const WindowHole& hole : scene_.outside().windows()) {
    Emitter emitter;
    emitter.kind = Emitter::Kind::kWindow;
    emitter.center = hole.center;
    emitter.u = hole.half_width_m * hole.along;
    emitter.v = hole.half_height_m * Eigen::Vector3f::UnitZ();
    emitter.normal = hole.inwards;
    emitter.room = hole.room;
    emitters_.push_back(emitter);
  }
}

void Emitters::add_lights(const HomeModel& home) {
  for (const Light& light : home.lights) {
    if (!light.is_on) continue;
    Emitter emitter;
    emitter.room = light.room;
    emitter.center = light.position.cast<float>();
    const auto radius = static_cast<float>(light.radius_m);
    const Eigen::Vector3f lumens =
        static_cast<float>(light.lumens) * color_of_temperature(light.color_temperature_k);
    if (light.is_ceiling_panel) {
      emitter.kind = Emitter::Kind::kPanel;
      const double ceiling_m = home.rooms[light.room].floor_m + home.ceiling_height_m;
      emitter.center.z() = static_cast<float>(ceiling_m) - 0.033F;
      emitter.u = radius * Eigen::Vector3f::UnitX();
      emitter.v = radius * Eigen::Vector3f::UnitY();
      emitter.normal = -Eigen::Vector3f::UnitZ();
      emitter.strength = lumens / (kPi * 4 * radius * radius);
    } else {
      emitter.kind = Emitter::Kind::kLamp;
      emitter.radius_m = radius;
      emitter.strength = lumens / (4 * kPi);
      if (light.object) emitter.object = static_cast<std::uint16_t>(*light.object + 1);
    }
    emitters_.push_back(emitter);
  }
}

// Sends the sun's rays in through the windows and keeps where they land.
void Emitters::add_sun_spots(std::size_t room_count) {
  sun_spots_.resize(room_count);
  const Outside& outside = scene_.outside();
  if (!outside.has_sun()) return;
  const Eigen::Vector3f down = -outside.sun_direction();
  // Window after window for every sample, so that any run of the spots is a fair choice of all.
  const EvenPoints points(17);
  for (int i = 0; i < kSpotsPerWindow; ++i) {
    const Eigen::Vector2f at = 2 * points.at(i) - Eigen::Vector2f::Ones();
    for (const WindowHole& hole : outside.windows()) {
      const float facing = hole.inwards.dot(down);
      if (facing <= 0.01F || hole.room >= room_count) continue;
      const float area = 4 * hole.half_width_m * hole.half_height_m;
      const Eigen::Vector3f flux = outside.sun_illuminance() * facing * area / kSpotsPerWindow;
      const Eigen::Vector3f start = hole.center + at.x() * hole.half_width_m * hole.along +
                                    at.y() * hole.half_height_m * Eigen::Vector3f::UnitZ();
      const auto hit = scene_.rays().first_hit(start, down, kGap, 100, RayCaster::Meets::kOpaque);
      if (!hit) continue;
      const Eigen::Vector3f point = start + hit->distance * down;
      const SurfaceLook look = scene_.look_at(*hit, point, 0.1F);
      const SceneTriangle& triangle = scene_.triangles()[hit->triangle];
      const Eigen::Vector3f normal =
          triangle.normal.dot(down) < 0 ? triangle.normal : Eigen::Vector3f(-triangle.normal);
      sun_spots_[hole.room].push_back(
          {point + kGap * normal, normal, look.albedo.cwiseProduct(flux) / kPi});
    }
  }
}

void Emitters::join_rooms(const HomeModel& home) {
  const Eigen::Vector2d grown = Eigen::Vector2d::Constant(home.wall_thickness_m + 0.01);
  for (const Room& room : home.rooms) {
    // Of one storey all; of several up to the middle of the slab, stair halls to the next landing.
    const bool is_one = home.storeys.size() == 1;
    const auto floor = static_cast<float>(room.floor_m);
    const auto ceiling = static_cast<float>(room.floor_m + home.ceiling_height_m);
    constexpr float kAll = std::numeric_limits<float>::infinity(), kHalfSlab = 0.13F;
    areas_.push_back({{room.interior.min - grown, room.interior.max + grown},
                      is_one ? -kAll : floor - kHalfSlab - (room.open_floor ? 0.2F : 0.0F),
                      is_one ? kAll : ceiling + kHalfSlab + (room.open_ceiling ? 0.2F : 0.0F),
                      {},
                      {}});
  }
  const auto join = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = 0; i < emitters_.size(); ++i) {
      if (emitters_[i].room == from) areas_[to].emitters.push_back(i);
    }
    areas_[to].sun_rooms.push_back(from);
  };
  for (std::size_t room = 0; room < home.rooms.size(); ++room) join(room, room);
  for (const Door& door : home.doors) {
    if (!door.other_room || (door.has_leaf && door.open_rad < 0.05)) continue;
    join(door.room, *door.other_room);
    join(*door.other_room, door.room);
  }
  for (const Staircase& stairs : home.stairs) {
    join(stairs.lower_room, stairs.upper_room);
    join(stairs.upper_room, stairs.lower_room);
  }
  for (Area& area : areas_) {
    for (auto* list : {&area.emitters, &area.sun_rooms}) {
      std::sort(list->begin(), list->end());
      list->erase(std::unique(list->begin(), list->end()), list->end());
    }
  }
}

// About the luminance that it would send without anything in its way.
float Emitters::expected(const Emitter& emitter, const Eigen::Vector3f& point,
                         const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f towards = emitter.center - point;
  const float size = emitter.u.norm() + emitter.v.norm() + emitter.radius_m;
  const float squared = std::max(towards.squaredNorm(), 0.25F * size * size + 0.01F);
  // Even where the middle lies below the horizon a part may rise above it.
  if (normal.dot(towards) < -size) return 0;
  if (emitter.kind == Emitter::Kind::kLamp) return luminance(emitter.strength) / squared;
  if (emitter.normal.dot(-towards) <= 0) return 0;
  const float area = 4 * emitter.u.norm() * emitter.v.norm();
  const Eigen::Vector3f radiance = emitter.kind == Emitter::Kind::kPanel
                                       ? emitter.strength
                                       : scene_.outside().mean_radiance(towards.normalized());
  const float facing = std::max(0.15F, emitter.normal.dot(-towards) / towards.norm());
  return luminance(radiance) * area * facing / squared;
}

template <typename Visit>
void Emitters::visit_areas(const Eigen::Vector3f& point, const Visit& visit) const {
  const Eigen::Vector2d place = point.head<2>().cast<double>();
  for (const Area& area : areas_) {
    const bool is_outside = (place.array() < area.rectangle.min.array()).any() ||
                            (place.array() > area.rectangle.max.array()).any();
    if (!is_outside && point.z() >= area.from_m && point.z() <= area.to_m) visit(area);
  }
}

Flux Emitters::flux(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, std::uint32_t seed,
                    std::uint64_t& rays) const {
  std::vector<bool> is_taken(emitters_.size());
  std::vector<std::pair<std::size_t, float>> candidates;
  float total = 0;
  visit_areas(point, [&](const Area& area) {
    for (const std::size_t i : area.emitters) {
      if (is_taken[i]) continue;
      is_taken[i] = true;
      const float light = expected(emitters_[i], point, normal);
      if (light <= 0) continue;
      candidates.emplace_back(i, light);
      total += light;
    }
  });
  Flux flux = Flux::Zero();
  for (const auto& [i, light] : candidates) {
    // Every emitter its share of rays, but for those whose light would hardly be seen.
    if (light < 0.003F * total) continue;
    const float share = std::sqrt(light / total);
    const int count = std::max(4, static_cast<int>(static_cast<float>(samples_) * share));
    flux += sample(emitters_[i], point, normal, count,
                   seed + 0x9e3779b9U * static_cast<std::uint32_t>(i + 1), rays);
  }
  return flux;
}

Flux Emitters::sun_bounce(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                          std::uint32_t seed, std::uint64_t& rays) const {
  std::vector<bool> is_taken(sun_spots_.size());
  Flux flux = Flux::Zero();
  visit_areas(point, [&](const Area& area) {
    for (const std::size_t room : area.sun_rooms) {
      if (is_taken[room]) continue;
      is_taken[room] = true;
      flux += sample_spots(sun_spots_[room], point, normal, seed, rays);
    }
  });
  return flux;
}

Flux Emitters::sample(const Emitter& emitter, const Eigen::Vector3f& point,
                      const Eigen::Vector3f& normal, int count, std::uint32_t seed,
                      std::uint64_t& rays) const {
  Flux flux = Flux::Zero();
  const EvenPoints points(seed);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f at = points.at(i);
    Eigen::Vector3f target;
    if (emitter.kind == Emitter::Kind::kLamp) {
      const float height = 2 * at.x() - 1, angle = 2 * kPi * at.y();
      const float ring = std::sqrt(std::max(0.0F, 1 - height * height));
      target = emitter.center + emitter.radius_m * Eigen::Vector3f(ring * std::cos(angle),
                                                                   ring * std::sin(angle), height);
    } else {
      target = emitter.center + (2 * at.x() - 1) * emitter.u + (2 * at.y() - 1) * emitter.v;
    }
    const Eigen::Vector3f towards = target - point;
    const float distance = towards.norm();
    if (distance < 1e-4F) continue;
    const Eigen::Vector3f direction = towards / distance;
    if (normal.dot(direction) <= 0) continue;
    if (emitter.kind == Emitter::Kind::kLamp) {
      const float left = lamp_light_left(emitter, point, towards, rays);
      const float nearest = std::max(distance, emitter.radius_m);
      if (left > 0) add_light(flux, direction, emitter.strength * left / (nearest * nearest));
      continue;
    }
    const float facing = -emitter.normal.dot(direction);
    if (facing <= 0) continue;
    ++rays;
    if (scene_.rays().is_blocked(point, direction, 0, distance - kGap)) continue;
    const Eigen::Vector3f radiance = emitter.kind == Emitter::Kind::kPanel
                                         ? emitter.strength
                                         : scene_.outside().mean_radiance(direction);
    const float area = 4 * emitter.u.norm() * emitter.v.norm();
    // Close to the emitter single samples would weigh without bound.
    const float squared = std::max(distance * distance, 0.02F * area);
    add_light(flux, direction, radiance * area * facing / squared);
  }
  return flux / static_cast<float>(count);
}

// The share of a lamp's light that arrives: its own shade dims, what lies below the shade and
// everything else blocks.
float Emitters::lamp_light_left(const Emitter& lamp, const Eigen::Vector3f& point,
                                const Eigen::Vector3f& towards, std::uint64_t& rays) const {
  constexpr int kMaxLayers = 6;
  if (lamp.object == 0) {
    ++rays;
    return scene_.rays().is_blocked(point, towards, 0, 1 - 1e-4F) ? 0.0F : 1.0F;
  }
  float left = 1, start = 0;
  for (int layer = 0; layer < kMaxLayers; ++layer) {
    ++rays;
    const auto hit =
        scene_.rays().first_hit(point, towards, start, 1 - 1e-4F, RayCaster::Meets::kOpaque);
    if (!hit) return left;
    if (scene_.triangles()[hit->triangle].object != lamp.object) return 0;
    const float height = point.z() + hit->distance * towards.z();
    if (height < lamp.center.z() - kShadeReach) return 0;
    // Glass bulbs and the two faces of a shade count once.
    left = kShadeTransmission;
    start = hit->distance + kGap / towards.norm();
  }
  return left;
}

Flux Emitters::sample_spots(const std::vector<SunSpot>& spots, const Eigen::Vector3f& point,
                            const Eigen::Vector3f& normal, std::uint32_t seed,
                            std::uint64_t& rays) const {
  Flux flux = Flux::Zero();
  if (spots.empty()) return flux;
  // Spots follow one another as evenly spread points do, so any run of them is a fair sample.
  const std::size_t count = std::min(spots.size(), static_cast<std::size_t>(samples_));
  const std::size_t first = scramble(seed ^ 0xabcdef01U) % spots.size();
  for (std::size_t i = 0; i < count; ++i) {
    const SunSpot& spot = spots[(first + i) % spots.size()];
    const Eigen::Vector3f towards = spot.position - point;
    const float distance = towards.norm();
    if (distance < 2 * kGap) continue;
    const Eigen::Vector3f direction = towards / distance;
    const float leaving = -spot.normal.dot(direction);
    if (leaving <= 0 || normal.dot(direction) <= 0) continue;
    ++rays;
    if (scene_.rays().is_blocked(point, direction, 0, distance - kGap)) continue;
    const float squared = std::max(distance * distance, kNearestSpot * kNearestSpot);
    add_light(flux, direction, spot.intensity * leaving / squared);
  }
  return flux * (static_cast<float>(spots.size()) / static_cast<float>(count));
}

Eigen::Vector3f Emitters::sun(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                              std::uint32_t seed, std::uint64_t& rays) const {
  const Outside& outside = scene_.outside();
  if (!outside.has_sun()) return Eigen::Vector3f::Zero();
  const float facing = normal.dot(outside.sun_direction());
  if (facing <= 0) return Eigen::Vector3f::Zero();
  const TangentAxes axes(outside.sun_direction());
  const Eigen::Vector2f at = EvenPoints(seed).at(0);
  const float radius = kSunRadius * std::sqrt(at.x()), angle = 2 * kPi * at.y();
  const Eigen::Vector3f direction =
      outside.sun_direction() + radius * (std::cos(angle) * axes.u + std::sin(angle) * axes.v);
  if (!outside.seen_through_a_window(point, direction)) return Eigen::Vector3f::Zero();
  ++rays;
  if (scene_.rays().is_blocked(point, direction, 0, 100)) return Eigen::Vector3f::Zero();
  return outside.sun_illuminance() * facing;
}

}  // namespace roomwise::simulation
