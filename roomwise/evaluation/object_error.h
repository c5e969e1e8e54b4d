#pragma once

#include <Eigen/Core>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/oriented_box.h"

namespace roomwise::evaluation {

// A thing that is there.
struct TrueObject {
  std::string kind;  // "bed": what it is called where it is found
  geometry::OrientedBox box;
};

// A thing that was found, in the truth's frame, m.
struct FoundObject {
  std::string kind;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

struct ObjectMatch {
  std::size_t truth = 0;     // index
  std::size_t found = 0;     // index
  double from_box_m = 0;     // the found position from the nearest point of the true box
  double from_center_m = 0;  // and from its middle
};

struct ObjectCounts {
  std::size_t matched = 0;
  std::size_t missed = 0;  // there, but not found
  std::size_t wrong = 0;   // found, but no such thing is there
};

struct ObjectErrors {
  std::vector<ObjectMatch> matches;  // by truth
  ObjectCounts all;
  std::map<std::string, ObjectCounts> by_kind;

  // Of the matches, m; 0 without any. `share` in [0, 1]: 0.5 is the median.
  [[nodiscard]] double from_box_quantile_m(double share) const;
  [[nodiscard]] double from_center_quantile_m(double share) const;
};

// Pairs what was found with what is there: of one kind, at most `most_distance_m` from the true
// box, the closest pair first, each used once. The distance must be positive.
[[nodiscard]] Expected<ObjectErrors> object_errors(std::span<const TrueObject> truth,
                                                   std::span<const FoundObject> found,
                                                   double most_distance_m = 1.0);

}  // namespace roomwise::evaluation
