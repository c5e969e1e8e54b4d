#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/home/stored_values.h"
#include "roomwise/objects/instances/instances.h"

// How things stand in columns: those that are there (instances) and those of the past. Private to
// home/.
namespace roomwise::home {

static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));

inline Bytes points_to_blob(const std::vector<Eigen::Vector3f>& points) {
  if (points.empty()) return {};
  return to_blob({points.front().data(), 3 * points.size()});
}

// Absent where they are not whole points of finite numbers.
inline std::optional<std::vector<Eigen::Vector3f>> blob_to_points(const Bytes& bytes) {
  if (bytes.size() % sizeof(Eigen::Vector3f) != 0) return std::nullopt;
  const std::vector<float> values = to_floats(bytes);
  if (!std::ranges::all_of(values, [](float v) { return std::isfinite(v); })) return std::nullopt;
  std::vector<Eigen::Vector3f> points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  }
  return points;
}

inline network::PixelBox box_column(const Statement& row, int first) {
  const auto side = [&](int i) { return static_cast<float>(row.column<double>(first + i)); };
  return {side(0), side(1), side(2), side(3)};
}

inline std::array<double, 4> to_numbers(const network::PixelBox& box) {
  return {box.left, box.top, box.right, box.bottom};
}

inline std::array<double, 3> to_numbers(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

inline Eigen::Vector3d vector_column(const Statement& row, int first) {
  const auto [x, y, z] = row.columns<3>(first);
  return {x, y, z};
}

// The columns that instances and past_instances have in common, in order.
#define ROOMWISE_INSTANCE_COLUMNS                                                                  \
  "name, probability, observations, expected, keyframe_id, left_px, top_px, right_px, bottom_px, " \
  "tx_m, ty_m, tz_m, qx, qy, qz, qw, width_m, depth_m, height_m, sigma_x_m, sigma_y_m, "           \
  "sigma_z_m, visit_id"
constexpr int kInstanceColumns = 23;

inline auto instance_columns(const objects::Instance& instance) {
  const geometry::OrientedBox& box = instance.box_keyframe;
  return std::tuple(instance.name, instance.probability, instance.observations, instance.expected,
                    instance.keyframe_id, to_numbers(instance.picture_box),
                    home::to_numbers(box.world_from_box), to_numbers(box.size_m),
                    to_numbers(instance.sigma_m),
                    instance.visit == 0 ? std::nullopt : std::optional(instance.visit));
}

inline bool is_finite(const objects::Instance& instance) {
  return instance.box_keyframe.world_from_box.is_finite() &&
         instance.box_keyframe.size_m.allFinite() && instance.sigma_m.allFinite();
}

// ROOMWISE_INSTANCE_COLUMNS from `first` on.
inline objects::Instance read_instance(const Statement& row, int first) {
  objects::Instance instance;
  instance.name = row.column<std::string>(first);
  instance.probability = row.column<double>(first + 1);
  instance.observations = row.column<int>(first + 2);
  instance.expected = row.column<int>(first + 3);
  instance.keyframe_id = row.column<KeyframeId>(first + 4);
  instance.picture_box = box_column(row, first + 5);
  instance.box_keyframe = {pose_column(row, first + 9), vector_column(row, first + 16)};
  instance.sigma_m = vector_column(row, first + 19);
  instance.visit = row.column<std::optional<VisitId>>(first + 22).value_or(0);
  return instance;
}

}  // namespace roomwise::home
