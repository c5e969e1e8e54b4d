#include "laboratory/simulation/render/light_points.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <unordered_set>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"
#include "laboratory/simulation/scene/sampling.h"

namespace roomwise::simulation {
namespace {

constexpr float kCell = 0.06F;    // m: light is gathered about this densely
constexpr float kPlane = 0.02F;   // m: parallel planes further apart have points of their own
constexpr float kBuried = 0.05F;  // m: how far an open place sees at least

int bin(float coordinate) {
  return static_cast<int>(std::lround(1.3F * coordinate));
}

std::array<int, 3> cell_of(const Eigen::Vector3f& position) {
  return {floor_to_int(position.x() / kCell), floor_to_int(position.y() / kCell),
          floor_to_int(position.z() / kCell)};
}

std::uint64_t cell_key(std::uint16_t object, const std::array<int, 3>& cell) {
  std::uint64_t key = object;
  for (const int index : cell) {
    key = (key << 16) | (static_cast<std::uint64_t>(index + 32768) & 0xffffU);
  }
  return key;
}

Eigen::Vector3f illuminance(const Flux& flux, const Eigen::Vector3f& normal) {
  return (normal.transpose() * flux).transpose().cwiseMax(0.0F);
}

struct PlaceKeyHash {
  std::size_t operator()(const PlaceKey& key) const {
    return key.cell * 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(key.facing) * 0x85ebca6bU +
           static_cast<std::uint64_t>(key.plane) * 0xc2b2ae35U;
  }
};

Eigen::Vector3f middle_of(const Scene& scene, const SceneTriangle& triangle) {
  const auto [a, b, c] = triangle.corners;
  return (scene.positions()[a] + scene.positions()[b] + scene.positions()[c]) / 3;
}

LightPoint point_at(const SceneTriangle& triangle, const Eigen::Vector3f& position, int side) {
  const Eigen::Vector3f normal = side == 0 ? triangle.normal : Eigen::Vector3f(-triangle.normal);
  return {position + kGap * normal, normal, 1};
}

PlaceKey key_of(std::uint16_t object, const LightPoint& point) {
  const Eigen::Vector3f& normal = point.normal;
  return {cell_key(object, cell_of(point.position)),
          bin(normal.x()) * 9 + bin(normal.y()) * 3 + bin(normal.z()),
          floor_to_int(normal.dot(point.position) / kPlane)};
}

}  // namespace

float openness_of(const RayCaster& rays, const LightPoint& point, std::uint32_t seed) {
  const TangentAxes axes(point.normal);
  const EvenPoints points(seed);
  int open = 0;
  for (int ray = 0; ray < kOpennessRays; ++ray) {
    const Eigen::Vector3f direction = cosine_direction(point.normal, axes, points.at(ray));
    open += rays.is_blocked(point.position, direction, 0, kBuried) ? 0 : 1;
  }
  return static_cast<float>(open) / kOpennessRays;
}

CornerPoints::CornerPoints(const Scene& scene, ThreadPool& pool)
    : scene_(scene), corners_(scene.positions().size()) {
  note_corners();
  place_points(pool);
  index_points();
}

void CornerPoints::note_corners() {
  for (const SceneTriangle& triangle : scene_.triangles()) {
    if (triangle.patch >= 0) continue;
    const auto& positions = scene_.positions();
    const Eigen::Vector3f middle = middle_of(scene_, triangle);
    for (const std::uint32_t corner : triangle.corners) {
      if (corners_[corner].is_used) continue;
      const Eigen::Vector3f inwards = middle - positions[corner];
      const float step = std::min(0.3F, 0.006F / std::max(1e-6F, inwards.norm()));
      corners_[corner] = {true,
                          triangle.object,
                          triangle.normal,
                          positions[corner] + step * inwards,
                          {kNone, kNone}};
    }
  }
}

Eigen::Vector3f CornerPoints::corner_normal(std::uint32_t corner) const {
  const Eigen::Vector3f& normal = scene_.normals()[corner];
  return normal.dot(corners_[corner].plane_normal) < 0 ? Eigen::Vector3f(-normal) : normal;
}

// The sides of all triangles outside patches, those of one place together.
std::vector<CornerPoints::Side> CornerPoints::sides_by_place() const {
  const auto& triangles = scene_.triangles();
  std::vector<Side> sides;
  sides.reserve(2 * triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i].patch >= 0) continue;
    const Eigen::Vector3f middle = middle_of(scene_, triangles[i]);
    for (const int side : {0, 1}) {
      sides.push_back({key_of(triangles[i].object, point_at(triangles[i], middle, side)), i, side});
    }
  }
  std::ranges::sort(sides);
  return sides;
}

// The first side of a place whose middle lies in the open, or else the first that is not buried, so
// that what lies close behind a visible surface is not taken for it.
std::optional<LightPoint> CornerPoints::point_of_place(std::span<const Side> sides,
                                                       std::uint64_t& rays) const {
  constexpr float kOpen = 0.7F;
  std::optional<LightPoint> second;
  for (const Side& side : sides) {
    const SceneTriangle& triangle = scene_.triangles()[side.triangle];
    LightPoint point = point_at(triangle, middle_of(scene_, triangle), side.side);
    point.openness = openness_of(scene_.rays(), point, side.triangle);
    rays += kOpennessRays;
    if (point.openness >= kOpen) return point;
    if (!second && point.openness >= kMinOpenness) second = point;
  }
  return second;
}

std::uint32_t CornerPoints::add_point(std::uint16_t object, const LightPoint& point) {
  points_.push_back(point);
  point_object_.push_back(object);
  return static_cast<std::uint32_t>(points_.size() - 1);
}

// Triangles' middles first: they lie off the creases where surfaces meet. Then what is near corners
// and has no point yet.
void CornerPoints::place_points(ThreadPool& pool) {
  const std::vector<Side> sides = sides_by_place();
  std::vector<std::size_t> first;  // of every place, and the end
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i == 0 || sides[i].place != sides[i - 1].place) first.push_back(i);
  }
  const std::size_t places = first.size();
  first.push_back(sides.size());
  const auto sides_of = [&](std::size_t place) {
    return std::span(sides).subspan(first[place], first[place + 1] - first[place]);
  };

  constexpr std::size_t kChunk = 1024;
  std::vector<std::optional<LightPoint>> points(places);
  std::atomic<std::uint64_t> traced = 0;
  pool.parallel_for((places + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    std::uint64_t rays = 0;
    for (std::size_t i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, places); ++i) {
      points[i] = point_of_place(sides_of(i), rays);
    }
    traced += rays;
  });
  rays_ += traced;

  const auto& triangles = scene_.triangles();
  for (auto& list : point_of_) list.assign(triangles.size(), kNone);
  std::unordered_set<PlaceKey, PlaceKeyHash> taken;
  for (std::size_t i = 0; i < places; ++i) {
    if (!points[i]) continue;
    const SceneTriangle& any = triangles[sides_of(i).front().triangle];
    const std::uint32_t point = add_point(any.object, *points[i]);
    taken.insert(sides_of(i).front().place);
    for (const Side& side : sides_of(i)) {
      const auto face = static_cast<std::size_t>(side.side);
      point_of_[face][side.triangle] = point;
      for (const std::uint32_t corner : triangles[side.triangle].corners) {
        Corner& at = corners_[corner];
        const bool is_turned = at.plane_normal.dot(triangles[side.triangle].normal) < 0;
        at.own_point[is_turned ? 1 - face : face] = point;
      }
    }
  }
  for (const SceneTriangle& triangle : triangles) {
    if (triangle.patch >= 0) continue;
    const Eigen::Vector3f middle = middle_of(scene_, triangle);
    for (const std::uint32_t corner : triangle.corners) {
      const Eigen::Vector3f& position = scene_.positions()[corner];
      if ((position - middle).norm() < kCell / 2) continue;
      for (const int side : {0, 1}) {
        LightPoint point = point_at(triangle, position + 0.25F * (middle - position), side);
        const PlaceKey key = key_of(triangle.object, point);
        if (taken.contains(key)) continue;
        point.openness = openness_of(scene_.rays(), point, corner);
        rays_ += kOpennessRays;
        if (point.openness < kMinOpenness) continue;
        taken.insert(key);
        add_point(triangle.object, point);
      }
    }
  }
}

void CornerPoints::index_points() {
  const std::vector<std::uint32_t> order = LightPointIndex::order_of(points_, point_object_);
  std::vector<LightPoint> points;
  std::vector<std::uint16_t> objects;
  std::vector<std::uint32_t> new_index(points_.size());
  for (const std::uint32_t point : order) {
    new_index[point] = static_cast<std::uint32_t>(points.size());
    points.push_back(points_[point]);
    objects.push_back(point_object_[point]);
  }
  points_ = std::move(points);
  point_object_ = std::move(objects);
  const auto renumber = [&](std::uint32_t& point) {
    if (point != kNone) point = new_index[point];
  };
  for (auto& list : point_of_) std::for_each(list.begin(), list.end(), renumber);
  for (Corner& corner : corners_) {
    std::for_each(corner.own_point.begin(), corner.own_point.end(), renumber);
  }
  index_ = LightPointIndex(points_, point_object_);
}

Eigen::Vector3f CornerPoints::at_middle(const std::vector<Flux>& fluxes, std::uint32_t triangle,
                                        int side) const {
  const std::uint32_t point = point_of_[static_cast<std::size_t>(side)][triangle];
  if (point == kNone) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f& normal = scene_.triangles()[triangle].normal;
  return illuminance(fluxes[point], side == 0 ? normal : Eigen::Vector3f(-normal));
}

void CornerPoints::find_neighbors(std::size_t point,
                                  std::vector<LightPointIndex::Neighbor>& neighbors) const {
  const LightPoint& at = points_[point];
  index_.find(point_object_[point], at.position, at.normal, neighbors);
}

bool CornerPoints::find_sources(std::uint32_t corner, CornerSources& sources) const {
  const Corner& at = corners_[corner];
  if (!at.is_used) return false;
  sources.neighbors.clear();
  sources.normal = corner_normal(corner);
  sources.own_point = at.own_point;
  index_.find(at.object, at.inside, sources.normal, sources.neighbors);
  return true;
}

}  // namespace roomwise::simulation
