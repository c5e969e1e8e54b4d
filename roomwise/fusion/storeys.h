#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/piecewise_mesh.h"

namespace roomwise::fusion {

// One level of a home, in the gravity-aligned frame. So that floor, rooms and ways need no third
// coordinate, storeys are drawn side by side along x: the plan. Of a home of one storey the plan is
// the gravity-aligned frame.
struct Storey {
  double floor_m = 0;                                               // its height
  Eigen::Vector2d plan_from_gravity = Eigen::Vector2d::Zero();      // what is added to x and y
  double plan_from_x_m = -std::numeric_limits<double>::infinity();  // from here on it is drawn
};

// A flight of stairs that somebody walked, from one storey to the next.
struct Staircase {
  std::size_t lower = 0;  // storey; the other is the next
  // Where one stands before the first step and behind the last one: on the plan.
  Eigen::Vector2d below_plan = Eigen::Vector2d::Zero(), above_plan = Eigen::Vector2d::Zero();
  // Middle of the first riser and of the last one's edge, gravity-aligned.
  Eigen::Vector2d foot_gravity = Eigen::Vector2d::Zero(), top_gravity = Eigen::Vector2d::Zero();
  double up_rad = 0;   // heading of who begins to climb, from x towards y
  double end_rad = 0;  // heading of who has climbed; the same where it is straight
  // Along the way, from the first riser to the last, and how much higher that is.
  double run_m = 0, height_m = 0;
  int steps = 0;                                       // risers; 0: they could not be counted
  double width_m = 0;                                  // 0: not seen
  bool has_left_rail = false, has_right_rail = false;  // for who climbs; seen, not excluded
};

// From the lowest on; none: one storey with its floor at z = 0.
class Storeys {
 public:
  Storeys() = default;
  explicit Storeys(std::vector<Storey> storeys, std::vector<Staircase> stairs = {})
      : storeys_(std::move(storeys)), stairs_(std::move(stairs)) {}

  [[nodiscard]] std::size_t count() const { return storeys_.empty() ? 1 : storeys_.size(); }
  [[nodiscard]] bool are_several() const { return storeys_.size() > 1; }
  [[nodiscard]] const std::vector<Storey>& all() const { return storeys_; }
  [[nodiscard]] const std::vector<Staircase>& stairs() const { return stairs_; }
  [[nodiscard]] double floor_m(std::size_t storey) const {
    return storeys_.empty() ? 0 : storeys_[storey].floor_m;
  }
  // The one whose floor is the next below, give or take what a map sags.
  [[nodiscard]] std::size_t at_height(double z_m) const;
  [[nodiscard]] std::size_t at_plan(const Eigen::Vector2d& point_plan) const;
  // z on the plan is the height over the storey's floor.
  [[nodiscard]] Eigen::Vector3d plan_from_gravity(const Eigen::Vector3d& point_gravity) const;
  [[nodiscard]] Eigen::Vector3d gravity_from_plan(const Eigen::Vector3d& point_plan) const;
  // The stairs over whose steps a place of the plan lies, on either storey; null: over none.
  [[nodiscard]] const Staircase* stairs_at(const Eigen::Vector2d& point_plan) const;
  // How far a place of the plan lies beyond the last step of stairs (`is_up`), or, going down,
  // beyond the first; below 0 before it.
  [[nodiscard]] double beyond_m(const Staircase& stairs, bool is_up,
                                const Eigen::Vector2d& point_plan) const;

 private:
  std::vector<Storey> storeys_;
  std::vector<Staircase> stairs_;
};

// Walks as camera places in the gravity-aligned frame, in the order of time.
using CameraPath = std::vector<Eigen::Vector3d>;

struct StoreysFound {
  std::vector<double> floors_m;   // from the lowest on; at most one: no storeys to tell apart
  std::vector<Staircase> stairs;  // without places on the plan
};

// The levels that people walked on, and the stairs between them. A level is a height at which the
// surface lies under the path for a few strides (kMinWalked_m), farther than a person is tall from
// any level that was walked more: whoever stands below must have room, and landings within a flight
// are nearer. Steps are counted by the one spacing that all treads of a flight share. Fails where
// the mesh cannot be read.
[[nodiscard]] Expected<StoreysFound> find_storeys(const PiecewiseMesh& mesh_gravity,
                                                  std::span<const CameraPath> paths);

// How high the only level that people walked on lies where z = 0 is another one, which they left
// within a few strides: a hall from which stairs lead to the flat. 0 otherwise.
[[nodiscard]] double only_level_m(const StoreysFound& found);

}  // namespace roomwise::fusion
