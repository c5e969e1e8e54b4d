#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::objects {

// A kind of thing that homes have: one row of kinds.json.
struct Kind {
  std::string name;
  std::vector<std::string> labels;  // of networks, that mean it
  // Usual sizes: longer and shorter level side and height, m.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  bool stands_on_floor = false;
  bool is_moved_about = false;  // by people, from day to day
  bool is_spoken_of = true;     // otherwise it only competes with what looks like it
};

// The rows of kinds.json, which is compiled in; by name.
[[nodiscard]] std::span<const Kind> standard_kinds();
// Absent for a word that somebody added to a home's vocabulary.
[[nodiscard]] const Kind* find_kind(std::string_view name);
// How large such things usually are, in one number, m; half a metre where nobody knows: the mean of
// the sides by their logarithms, and the longer level side.
[[nodiscard]] double usual_extent_m(std::string_view name);
[[nodiscard]] double typical_length_m(std::string_view name);
// As Kind::size_m, m; half a metre each where nobody knows.
[[nodiscard]] Eigen::Vector3d usual_size_m(std::string_view name);

// Fails, naming the row, where a field is missing or of another type, a size is not positive, or
// two rows have one name.
[[nodiscard]] Expected<std::vector<Kind>> parse_kinds(std::string_view json);

}  // namespace roomwise::objects
