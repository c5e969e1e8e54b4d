#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
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
  // Whether it counts as missed where it is not found: the walk showed it well, and there is a word
  // for it.
  bool is_expected = true;
  std::set<std::string> also_called = {};  // other names that are not wrong
  // What stands in it without being told of one by one, as books in a bookcase: found there it is
  // neither right nor wrong.
  std::set<std::string> holds = {};
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

// By the kind of the true thing; what is wrong, by what it was called.
struct ObjectCounts {
  std::size_t matched = 0;     // expected, and found
  std::size_t beyond = 0;      // found, though not expected
  std::size_t missed = 0;      // expected, but not found
  std::size_t duplicates = 0;  // found once more
  std::size_t wrong = 0;       // found, but no such thing is there

  [[nodiscard]] std::size_t found() const { return matched + beyond + duplicates + wrong; }
  ObjectCounts& operator+=(const ObjectCounts& other);
};

struct ObjectErrors {
  std::vector<ObjectMatch> matches;     // by truth
  std::vector<ObjectMatch> duplicates;  // found once more, with the nearest thing of its name
  std::vector<std::size_t> missed;      // indices of the truth
  std::vector<std::size_t> wrong;       // indices of what was found
  ObjectCounts all;
  std::map<std::string, ObjectCounts> by_kind;

  // Of the matches, m; 0 without any. `share` in [0, 1]: 0.5 is the median.
  [[nodiscard]] double from_box_quantile_m(double share) const;
  [[nodiscard]] double from_center_quantile_m(double share) const;
};

// Pairs what was found with what is there: of one kind, at most `max_distance_m` from the true
// box, the closest pair first, each used once. What is left over that near to a thing of its kind
// is that thing once more. The distance must be positive.
[[nodiscard]] Expected<ObjectErrors> object_errors(std::span<const TrueObject> truth,
                                                   std::span<const FoundObject> found,
                                                   double max_distance_m = 1.0);

}  // namespace roomwise::evaluation
