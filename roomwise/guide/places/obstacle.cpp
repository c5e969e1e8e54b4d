#include "roomwise/guide/places/obstacle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "roomwise/guide/places/clearance.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kStride_px = 4;  // every 16th pixel: at a metre they are 8 mm apart
constexpr double kSquare_m = 0.1;
// A camera that looks up or down by more than 60 degrees sees the floor or the ceiling.
constexpr double kMinForward = 0.5;

// The surface over each square of floor.
class Squares {
 public:
  explicit Squares(const ObstacleOptions& options)
      : options_(options),
        rows_(count(options.farthest_m - options.nearest_m)),
        columns_(count(2 * options.beside_m)),
        squares_(static_cast<std::size_t>(rows_ * columns_)) {}

  // A piece of surface, m ahead and to the left.
  void add(const Vector2d& place, double area_m2) {
    const auto row = index((place.x() - options_.nearest_m) / kSquare_m);
    const auto column = index((place.y() + options_.beside_m) / kSquare_m);
    if (row < 0 || row >= rows_ || column < 0 || column >= columns_) return;
    Square& square = squares_[static_cast<std::size_t>(row * columns_ + column)];
    square.area_m2 += area_m2;
    square.weighted += area_m2 * place;
  }

  // The middles of surface, nearer rows first.
  [[nodiscard]] std::vector<Vector2d> with_enough() const {
    std::vector<Vector2d> places;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const Square& square = *at(row, column);
        // It must have its share of it: else it is a neighbour's border.
        const bool is_enough = square.area_m2 >= options_.min_area_m2 / 9 &&
                               area_around_m2(row, column) >= options_.min_area_m2;
        if (is_enough) places.push_back(square.weighted / square.area_m2);
      }
    }
    return places;
  }

 private:
  struct Square {
    double area_m2 = 0;
    Vector2d weighted = Vector2d::Zero();
  };
  [[nodiscard]] static int count(double length_m) {
    return static_cast<int>(std::ceil(length_m / kSquare_m - 1e-9));
  }
  [[nodiscard]] static int index(double squares) { return static_cast<int>(std::floor(squares)); }
  [[nodiscard]] const Square* at(int row, int column) const {
    const bool is_inside = row >= 0 && row < rows_ && column >= 0 && column < columns_;
    return is_inside ? &squares_[static_cast<std::size_t>(row * columns_ + column)] : nullptr;
  }
  [[nodiscard]] double area_around_m2(int row, int column) const {
    double area_m2 = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (const Square* const square = at(row + dy, column + dx)) area_m2 += square->area_m2;
      }
    }
    return area_m2;
  }

  const ObstacleOptions& options_;
  int rows_, columns_;
  std::vector<Square> squares_;
};

}  // namespace

Expected<void> ObstacleOptions::validate() const {
  if (!(highest_m > lowest_m && lowest_m >= 0)) {
    return fail("lowest_m is {} and highest_m {}; expected 0 or more, and more", lowest_m,
                highest_m);
  }
  if (!(farthest_m > nearest_m && nearest_m >= 0 && farthest_m <= 10)) {
    return fail("nearest_m is {} and farthest_m {}; expected 0 or more, and more up to 10",
                nearest_m, farthest_m);
  }
  if (!(beside_m > 0 && beside_m <= 10)) {
    return fail("beside_m is {}; expected more than 0, up to 10", beside_m);
  }
  if (!(min_area_m2 > 0)) return fail("min_area_m2 is {}; expected more than 0", min_area_m2);
  if (!(std::abs(up_camera.norm() - 1) < 1e-6)) {
    return fail("up_camera has the length {}; expected 1", up_camera.norm());
  }
  return {};
}

Expected<std::vector<Vector2d>> obstacles_seen(const image::DepthImage& depth,
                                               const geometry::PinholeCamera& camera,
                                               const ObstacleOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (depth.width() != camera.width || depth.height() != camera.height) {
    return fail("the depth image has {}x{} pixels; the camera {}x{}", depth.width(), depth.height(),
                camera.width, camera.height);
  }
  const Vector3d& up = options.up_camera;
  const Vector3d level = Vector3d::UnitZ() - up.z() * up;
  if (level.norm() < kMinForward) return std::vector<Vector2d>();
  const Vector3d forward = level.normalized();
  const Vector3d left = up.cross(forward);

  Squares squares(options);
  const double pixels = kStride_px * kStride_px / (camera.fx * camera.fy);
  for (int y = kStride_px / 2; y < depth.height(); y += kStride_px) {
    for (int x = kStride_px / 2; x < depth.width(); x += kStride_px) {
      if (depth.at(x, y) == 0) continue;
      const double depth_m = depth.at(x, y) / camera.depth_units_per_metre;
      // The lens distorts by millimetres here.
      const Vector3d point = camera.unproject_undistorted(Vector2d(x, y), depth_m);
      const double height_m = options.camera_height_m + up.dot(point);
      if (height_m < options.lowest_m || height_m > options.highest_m) continue;
      squares.add({forward.dot(point), left.dot(point)}, pixels * depth_m * depth_m);
    }
  }
  return squares.with_enough();
}

std::optional<ObstacleAhead> nearest_ahead(std::span<const Vector2d> obstacles,
                                           const WalkingCorridor& corridor) {
  ObstacleAhead obstacle;
  std::ranges::copy_if(obstacles, std::back_inserter(obstacle.all), [&](const Vector2d& place) {
    return place.x() <= corridor.length_m && std::abs(place.y()) <= corridor.half_width_m;
  });
  if (obstacle.all.empty()) return std::nullopt;
  const auto ahead_m = [](const Vector2d& place) { return place.x(); };
  obstacle.ahead_left_m = *std::ranges::min_element(obstacle.all, {}, ahead_m);
  obstacle.side = side_of(obstacle.all);
  return obstacle;
}

ObstacleAhead::Side side_of(std::span<const Vector2d> ahead_left_m) {
  using Side = ObstacleAhead::Side;
  const auto all_stand = [&](double side) {
    return std::ranges::all_of(ahead_left_m,
                               [&](const Vector2d& place) { return side * place.y() > kSquare_m; });
  };
  return all_stand(1) ? Side::kLeft : all_stand(-1) ? Side::kRight : Side::kAhead;
}

bool is_on_map(const Vector2d& obstacle, const fusion::FloorGrid& floor) {
  constexpr double kKnown_m = 0.15;
  return clearance_m(floor, obstacle) < kKnown_m;
}

Phrase obstacle_phrase(const std::string& begin, ObstacleAhead::Side side,
                       const KnownThing* thing) {
  using Side = ObstacleAhead::Side;
  Phrase phrase{begin + (thing != nullptr ? "thing" : "obstacle") +
                (side == Side::kAhead  ? "_ahead"
                 : side == Side::kLeft ? "_left"
                                       : "_right")};
  if (thing != nullptr) phrase.values = {{"thing", guide::thing(thing->name)}};
  return phrase;
}

Prompt hazard_prompt(const ObstacleAhead& obstacle, const KnownThing* thing, const Wording& wording,
                     TimestampNs now_ns) {
  const Phrase phrase = obstacle_phrase("hazard.", obstacle.side, thing);
  Prompt prompt = make_prompt(
      wording, "hazard", phrase.message_id, phrase.values, Confidence::kSure,
      after(now_ns, kHazardValid_s),
      fmt::format("the depth camera sees something {:.2f} m ahead", obstacle.ahead_left_m.x()));
  prompt.priority = Priority::kHazard;
  prompt.sound = Sound::kAlert;
  return prompt;
}

}  // namespace roomwise::guide
