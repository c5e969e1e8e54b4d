#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>

// How large things of a kind are in homes; private to objects/.
namespace roomwise::objects {

struct ClassSizePrior {
  static constexpr double kAny = std::numeric_limits<double>::infinity();

  std::string_view name;
  bool on_floor = false;
  // The shorter level side and the longest of the three, at least, m.
  double min_side_m = 0;
  double min_longest_m = 0;
  // The shorter and the longer level side and the height, at most, m; a hand's breadth more than
  // such things have, since a surface holds some of what the thing touches.
  double max_side_m = kAny;
  double max_length_m = kAny;
  double max_height_m = kAny;
  // The height and the longer level side, at least, m; less than such things have.
  double min_height_m = 0;
  double min_length_m = 0;
  // What is higher is no longer than that: fridges of two metres are narrow (max_length_at()).
  double tall_m = kAny;
  double max_length_of_tall_m = kAny;
  bool built_in = false;  // often; then the front alone is seen

  // The longer level side of what is as high, at most, m.
  [[nodiscard]] double max_length_at(double height_m) const {
    return height_m > tall_m ? max_length_of_tall_m : max_length_m;
  }
  // Whether something can be one that is as large as that. `size_m`: two level sides and the
  // height of the whole.
  [[nodiscard]] bool holds(const Eigen::Vector3d& size_m) const;
  // What was seen of a thing may be a part of it: its shorter level side half of the least side,
  // unless it is built in, its longer one nearly that. It may not be larger; where it stands on the
  // floor, without its rim.
  [[nodiscard]] bool fits_when_partial(const Eigen::Vector3d& seen_m) const;
  // What stands on the floor touches walls and other furniture, and in single homes its surface
  // holds more of them than the hand's breadth above: 15 % less, but for the height.
  [[nodiscard]] static Eigen::Vector3d without_rim(const Eigen::Vector3d& seen_m) {
    constexpr double kRim = 1.15;
    return {seen_m.x() / kRim, seen_m.y() / kRim, seen_m.z()};
  }
};

// Of a kind that nothing is known of: any size.
[[nodiscard]] ClassSizePrior size_prior_of(std::string_view name);

}  // namespace roomwise::objects
