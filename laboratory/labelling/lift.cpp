#include "laboratory/labelling/lift.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "roomwise/base/median.h"

namespace roomwise::labelling {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDrawn_px = 4;        // how well a person draws a border, standard deviation
constexpr double kOfSide = 0.04;       // and of the box's side, since a thing's outline differs
constexpr double kHidden = 0.2;        // of the side, where something hides a part
constexpr double kCut = 0.5;           // of the side, where the picture's border cuts it
constexpr double kPoseError_m = 0.02;  // of the recording's own truth
constexpr double kMaxSigma_m = 0.5;    // of a middle that is known at all
constexpr int kIterations = 20;

Vector2d middle_of(const network::PixelBox& box) {
  return {0.5 * static_cast<double>(box.left + box.right),
          0.5 * static_cast<double>(box.top + box.bottom)};
}
Vector2d sides_of(const network::PixelBox& box) {
  return {static_cast<double>(box.right - box.left), static_cast<double>(box.bottom - box.top)};
}

// Standard deviation of a box's middle along the picture's rows and columns, px.
Vector2d sigma_px(const PlacedView& view) {
  const Vector2d sides = sides_of(view.box);
  const auto along = [&](double side, bool is_cut) {
    return kDrawn_px + side * (is_cut ? kCut : view.is_occluded ? kHidden : kOfSide);
  };
  return {along(sides.x(), view.cut.left || view.cut.right),
          along(sides.y(), view.cut.top || view.cut.bottom)};
}

// What the box's sides are in space at a depth.
Vector2d extent_m(const PlacedView& view, double depth_m) {
  const Vector2d sides = sides_of(view.box);
  return {sides.x() * depth_m / view.camera.fx, sides.y() * depth_m / view.camera.fy};
}

// Where a first view or the depth puts the thing.
Vector3d first_guess(std::span<const PlacedView> views) {
  Vector3d sum = Vector3d::Zero();
  int with_depth = 0;
  for (const PlacedView& view : views) {
    if (!view.depth_m) continue;
    sum += view.world_from_camera * view.camera.unproject(middle_of(view.box), *view.depth_m);
    ++with_depth;
  }
  if (with_depth > 0) return sum / with_depth;
  // The point nearest to all rays.
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const PlacedView& view : views) {
    const Vector3d ray =
        (view.world_from_camera.rotation * view.camera.unproject(middle_of(view.box), 1))
            .normalized();
    const Matrix3d across = Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * view.world_from_camera.translation;
  }
  return normal.ldlt().solve(right);
}

struct NormalEquations {
  Matrix3d information = Matrix3d::Zero();
  Vector3d gradient = Vector3d::Zero();

  void add(double residual, const Vector3d& derivative, double sigma) {
    information += derivative * derivative.transpose() / (sigma * sigma);
    gradient += derivative * residual / (sigma * sigma);
  }
};

NormalEquations equations_at(const Vector3d& middle_world, std::span<const PlacedView> views) {
  NormalEquations equations;
  for (const PlacedView& view : views) {
    const Vector3d point = view.world_from_camera.inverse() * middle_world;
    if (point.z() < 0.05) continue;
    const Matrix3d camera_from_world = view.world_from_camera.rotation_matrix().transpose();
    const Vector2d ideal = view.camera.undistort(middle_of(view.box));
    const Vector2d off = view.camera.project_undistorted(point) - ideal;
    const Vector2d sigma = sigma_px(view);
    const double fx = view.camera.fx / point.z(), fy = view.camera.fy / point.z();
    // The truth's poses are not exact, which counts where the thing is near.
    const Vector2d pose_px(kPoseError_m * fx, kPoseError_m * fy);
    equations.add(off.x(),
                  fx * (camera_from_world.row(0) - point.x() / point.z() * camera_from_world.row(2))
                           .transpose(),
                  std::hypot(sigma.x(), pose_px.x()));
    equations.add(off.y(),
                  fy * (camera_from_world.row(1) - point.y() / point.z() * camera_from_world.row(2))
                           .transpose(),
                  std::hypot(sigma.y(), pose_px.y()));
    if (!view.depth_m) continue;
    const double size_m = extent_m(view, *view.depth_m).minCoeff();
    equations.add(point.z() - *view.depth_m - 0.25 * size_m, camera_from_world.row(2).transpose(),
                  0.05 + 0.5 * size_m);
  }
  return equations;
}

bool shows_all(const PlacedView& view) {
  return !view.is_occluded && view.cut == CutBorders{};
}

// The view that shows most of it, and largest.
const PlacedView& best_of(std::span<const PlacedView> views) {
  return *std::ranges::max_element(views, {}, [](const PlacedView& view) {
    return std::pair(shows_all(view), view.box.area());
  });
}

}  // namespace

std::optional<double> depth_in_middle_m(const image::DepthImage& depth,
                                        const geometry::PinholeCamera& camera,
                                        const network::PixelBox& box) {
  const Vector2d middle = middle_of(box), reach = 0.25 * sides_of(box);
  const auto from_x = static_cast<int>(std::floor(middle.x() - reach.x()));
  const auto from_y = static_cast<int>(std::floor(middle.y() - reach.y()));
  const auto to_x = static_cast<int>(std::ceil(middle.x() + reach.x()));
  const auto to_y = static_cast<int>(std::ceil(middle.y() + reach.y()));
  std::vector<double> depths_m;
  std::size_t places = 0;
  for (int y = from_y; y <= to_y; ++y) {
    for (int x = from_x; x <= to_x; ++x) {
      ++places;
      if (!depth.contains(x, y) || depth.at(x, y) == 0) continue;
      depths_m.push_back(depth.at(x, y) / camera.depth_units_per_metre);
    }
  }
  if (5 * depths_m.size() < places) return std::nullopt;
  return median_of(depths_m);
}

std::optional<LiftedThing> lift(std::span<const PlacedView> views) {
  if (views.empty()) return std::nullopt;
  Vector3d middle = first_guess(views);
  NormalEquations equations = equations_at(middle, views);
  for (int i = 0; i < kIterations; ++i) {
    // A view alone without depth leaves its ray's direction open: it is held where it is.
    const Matrix3d damped = equations.information + 1e-6 * Matrix3d::Identity();
    middle -= damped.ldlt().solve(equations.gradient);
    equations = equations_at(middle, views);
  }
  if (!middle.allFinite()) return std::nullopt;
  const double min_information =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(equations.information).eigenvalues()[0];
  LiftedThing thing;
  thing.sigma_m = 1 / std::sqrt(std::max(min_information, 1e-9));
  if (thing.sigma_m > kMaxSigma_m) return std::nullopt;

  const PlacedView& best = best_of(views);
  const double depth_m = (best.world_from_camera.inverse() * middle).z();
  if (depth_m < 0.05) return std::nullopt;
  const Vector2d extent = extent_m(best, depth_m);
  thing.box_world = {{best.world_from_camera.rotation, middle},
                     {extent.x(), extent.y(), extent.minCoeff()}};
  double squares = 0;
  int shown = 0;
  for (const PlacedView& view : views) {
    const Vector3d point = view.world_from_camera.inverse() * middle;
    if (!shows_all(view) || point.z() < 0.05) continue;
    squares += (view.camera.project(point) - middle_of(view.box)).squaredNorm();
    ++shown;
  }
  if (shown > 1) thing.residual_px = std::sqrt(squares / shown);
  return thing;
}

}  // namespace roomwise::labelling
