#include "laboratory/simulation/walk/piece_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr double kNearest_m = 1.0, kFarthest_m = 2.4;
constexpr double kMaxAside_rad = 75 * std::numbers::pi / 180;
constexpr double kSlantwise_rad = 35 * std::numbers::pi / 180;
constexpr double kApart_m = 0.5;
constexpr double kMinSeen = 0.75;
constexpr std::array kHeights_m{1.4, 1.3, 1.5};

// Those that one would choose first.
std::vector<StandingPlace> places_by_preference(const HomeModel& home, std::size_t object,
                                                const FreeSpace& space) {
  // So far away that it fills a good half of the picture's height.
  const double best_m =
      std::clamp(1.8 * home.objects[object].size_m.maxCoeff(), kNearest_m, kFarthest_m);
  std::vector<StandingPlace> places = places_before(home, object, space, kNearest_m, kFarthest_m);
  std::ranges::stable_sort(places, {}, [best_m](const StandingPlace& place) {
    return std::abs(place.distance_m - best_m) + std::abs(place.aside_rad - kSlantwise_rad);
  });
  return places;
}

}  // namespace

std::vector<Eigen::Vector3d> points_on(const PlacedObject& piece, const TriangleMesh& mesh) {
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
    points.push_back(piece.world_from_object *
                     ((1 - root) * corner(triangle, 0) + root * (1 - other) * corner(triangle, 1) +
                      root * other * corner(triangle, 2)));
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
                  const RenderedFrame& frame, const geometry::PinholeCamera& camera,
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
  return points_world.empty() ? 0 : seen / static_cast<double>(points_world.size());
}

WalkPose moving_pose(const geometry::RigidTransform& world_from_camera, std::size_t room,
                     double pace) {
  constexpr double kShutter_s = 0.02, kTurning_rad_s = 0.4, kStepping_m_s = 0.3;
  geometry::Vector6d half = geometry::Vector6d::Zero();  // of the way while the shutter is open
  half[1] = pace * kTurning_rad_s * kShutter_s / 2;      // about the camera's downward axis
  half[3] = pace * kStepping_m_s * kShutter_s / 2;
  WalkPose pose;
  pose.world_from_camera = world_from_camera;
  pose.world_from_camera_open = world_from_camera * geometry::RigidTransform::exp(-half);
  pose.world_from_camera_close = world_from_camera * geometry::RigidTransform::exp(half);
  pose.room = room;
  return pose;
}

std::vector<StandingPlace> places_before(const HomeModel& home, std::size_t object,
                                         const FreeSpace& space, double nearest_m,
                                         double farthest_m) {
  constexpr int kEvery = 2;  // cells
  const PlacedObject& piece = home.objects[object];
  const Footprint footprint = footprint_of(piece);
  const Eigen::Vector2d front = facing(footprint.yaw_rad);
  std::vector<StandingPlace> places;
  for (int row = 0; row < space.rows(); row += kEvery) {
    for (int column = 0; column < space.columns(); column += kEvery) {
      const Eigen::Vector2d place = space.cell_center(column, row);
      const Eigen::Vector2d from_middle = place - footprint.center;
      const double distance = from_middle.norm();
      if (distance < nearest_m || distance > farthest_m ||
          space.clearance_m(column, row) < kStandingRadius_m ||
          !contains(home.rooms[piece.room].interior, place)) {
        continue;
      }
      const double aside = std::acos(std::clamp(front.dot(from_middle) / distance, -1.0, 1.0));
      if (aside <= kMaxAside_rad) places.push_back({place, distance, aside});
    }
  }
  return places;
}

std::vector<PieceView> find_views(const HomeModel& home, std::size_t object,
                                  const TriangleMesh& mesh, const FreeSpace& space,
                                  const Renderer& renderer, const geometry::PinholeCamera& camera,
                                  std::size_t most, ThreadPool& pool) {
  const PlacedObject& piece = home.objects[object];
  const std::vector<Eigen::Vector3d> points = points_on(piece, mesh);
  const Eigen::Vector3d middle =
      piece.world_from_object * Eigen::Vector3d(0, 0, piece.size_m.z() / 2);
  const geometry::PinholeCamera coarse_camera = coarse(camera);

  std::vector<PieceView> views;
  std::vector<Eigen::Vector2d> tried;  // near them all is much the same
  for (const StandingPlace& place : places_by_preference(home, object, space)) {
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
    if (view.share_seen >= kMinSeen) views.push_back(view);
  }
  return views;
}

}  // namespace roomwise::simulation
