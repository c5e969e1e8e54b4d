#include "piece_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomwise/base/random.h"
#include "roomwise/simulation/home_geometry.h"

namespace roomwise::bench {
namespace {

using simulation::HomeModel;
using simulation::PlacedObject;

constexpr double kNearest_m = 1.0, kFarthest_m = 2.4;
constexpr double kMostAside_rad = 75 * std::numbers::pi / 180;
constexpr double kSlantwise_rad = 35 * std::numbers::pi / 180;
constexpr double kApart_m = 0.5;
constexpr double kPersonRadius_m = 0.25;
constexpr double kLeastSeen = 0.75;
constexpr std::array kHeights_m{1.4, 1.3, 1.5};

// Points all over a mesh, evenly by area; of the object frame.
std::vector<Eigen::Vector3d> surface_points(const simulation::TriangleMesh& mesh) {
  constexpr std::size_t kPoints = 500;
  const auto corner = [&](std::size_t triangle, std::size_t i) {
    return mesh.positions[mesh.triangles[triangle].corners[i]].cast<double>().eval();
  };
  std::vector<double> area_up_to;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    area += (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm();
    area_up_to.push_back(area);
  }
  std::vector<Eigen::Vector3d> points;
  RandomStream random(0, {mesh.triangles.size()});
  while (points.size() < kPoints && area > 0) {
    const auto found = std::ranges::lower_bound(area_up_to, area * random.uniform());
    const auto triangle =
        std::min(static_cast<std::size_t>(found - area_up_to.begin()), area_up_to.size() - 1);
    const double root = std::sqrt(random.uniform()), other = random.uniform();
    points.push_back((1 - root) * corner(triangle, 0) + root * (1 - other) * corner(triangle, 1) +
                     root * other * corner(triangle, 2));
  }
  return points;
}

geometry::RigidTransform looking_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d forward = (at - from).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d(forward.y(), -forward.x(), 0).normalized();
  Eigen::Matrix3d axes;
  axes << right, forward.cross(right), forward;
  return geometry::RigidTransform::from_matrix(axes, from);
}

// The same picture with fewer pixels, to test what it shows.
geometry::PinholeCamera coarse(geometry::PinholeCamera camera) {
  constexpr int kTimes = 4;
  camera.fx /= kTimes;
  camera.fy /= kTimes;
  camera.cx = (camera.cx + 0.5) / kTimes - 0.5;
  camera.cy = (camera.cy + 0.5) / kTimes - 0.5;
  camera.width /= kTimes;
  camera.height /= kTimes;
  return camera;
}

double share_seen(const std::vector<Eigen::Vector3d>& points_world, std::size_t object,
                  const simulation::RenderedFrame& frame, const geometry::PinholeCamera& camera,
                  const geometry::RigidTransform& world_from_camera) {
  constexpr float kTolerance_m = 0.05F;
  const geometry::RigidTransform camera_from_world = world_from_camera.inverse();
  double seen = 0;
  for (const Eigen::Vector3d& point_world : points_world) {
    const Eigen::Vector3d point = camera_from_world * point_world;
    if (point.z() < 0.1) continue;
    const Eigen::Vector2d pixel = camera.project(point);
    const int x = static_cast<int>(std::lround(pixel.x()));
    const int y = static_cast<int>(std::lround(pixel.y()));
    if (!frame.object.contains(x, y)) continue;
    const bool is_hidden = frame.object.at(x, y) != object + 1 && frame.depth_m.at(x, y) > 0 &&
                           frame.depth_m.at(x, y) < static_cast<float>(point.z()) - kTolerance_m;
    if (!is_hidden) ++seen;
  }
  return seen / static_cast<double>(points_world.size());
}

struct Place {
  Eigen::Vector2d place;
  double distance_m, aside_rad;
  double worse;  // than the view that one would choose
};

std::vector<Place> places_by_preference(const HomeModel& home, const PlacedObject& object,
                                        const simulation::FreeSpace& space) {
  constexpr int kEvery = 2;  // cells
  const simulation::Footprint footprint = simulation::footprint_of(object);
  const Eigen::Vector2d front = simulation::facing(footprint.yaw_rad);
  // So far away that it fills a good half of the picture's height.
  const double best_m = std::clamp(1.8 * object.size_m.maxCoeff(), kNearest_m, kFarthest_m);
  std::vector<Place> places;
  for (int row = 0; row < space.rows(); row += kEvery) {
    for (int column = 0; column < space.columns(); column += kEvery) {
      const Eigen::Vector2d place = space.cell_center(column, row);
      const Eigen::Vector2d from_middle = place - footprint.center;
      const double distance = from_middle.norm();
      if (distance < kNearest_m || distance > kFarthest_m ||
          space.clearance_m(column, row) < kPersonRadius_m ||
          !simulation::contains(home.rooms[object.room].interior, place)) {
        continue;
      }
      const double aside = std::acos(std::clamp(front.dot(from_middle) / distance, -1.0, 1.0));
      if (aside > kMostAside_rad) continue;
      places.push_back(
          {place, distance, aside, std::abs(distance - best_m) + std::abs(aside - kSlantwise_rad)});
    }
  }
  std::ranges::stable_sort(places, {}, &Place::worse);
  return places;
}

}  // namespace

std::vector<PieceView> find_views(const HomeModel& home, std::size_t object,
                                  const simulation::TriangleMesh& mesh,
                                  const simulation::FreeSpace& space,
                                  const simulation::Renderer& renderer,
                                  const geometry::PinholeCamera& camera, std::size_t most,
                                  ThreadPool& pool) {
  const PlacedObject& piece = home.objects[object];
  std::vector<Eigen::Vector3d> points = surface_points(mesh);
  for (Eigen::Vector3d& point : points) point = piece.world_from_object * point;
  const Eigen::Vector3d middle =
      piece.world_from_object * Eigen::Vector3d(0, 0, piece.size_m.z() / 2);
  const geometry::PinholeCamera coarse_camera = coarse(camera);

  std::vector<PieceView> views;
  std::vector<Eigen::Vector2d> tried;  // near them all is much the same
  for (const Place& place : places_by_preference(home, piece, space)) {
    if (views.size() == most) break;
    const auto is_within = [&](double distance_m) {
      return [&place, distance_m](const Eigen::Vector2d& other) {
        return (place.place - other).norm() < distance_m;
      };
    };
    constexpr double kMuchTheSame_m = 0.15;
    if (std::ranges::any_of(tried, is_within(kMuchTheSame_m)) ||
        std::ranges::any_of(views, [&](const PieceView& view) {
          return is_within(kApart_m)(view.world_from_camera.translation.head<2>());
        })) {
      continue;
    }
    tried.push_back(place.place);
    const double height = kHeights_m[views.size() % kHeights_m.size()];
    PieceView view;
    view.world_from_camera = looking_at({place.place.x(), place.place.y(), height}, middle);
    view.distance_m = place.distance_m;
    view.aside_rad = place.aside_rad;
    view.share_seen =
        share_seen(points, object, renderer.render(coarse_camera, view.world_from_camera, pool),
                   coarse_camera, view.world_from_camera);
    if (view.share_seen >= kLeastSeen) views.push_back(view);
  }
  return views;
}

}  // namespace roomwise::bench
