#pragma once

#include <Eigen/Core>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::objects {

// What something is called in a language, as guide::Phrasebook says it.
struct SpokenName {
  std::string name;
  std::string word_class;                    // of the language's own, as a rule its gender
  std::map<std::string, std::string> forms;  // where the class does not give them: "plural"
  std::vector<std::string> also;             // what else people call it
};
// {"name": ..., "class": ..., "also": [...], FORM: ...}
void from_json(const nlohmann::json& json, SpokenName& name);

// How large things of a kind are as a map shows them: longer and shorter level side and height, m.
// One in forty lies below the least, one above the most.
struct SizeDistribution {
  Eigen::Vector3d min_m, usual_m, max_m;

  // The logarithm of how dense such sizes lie about this one, by the logarithms of the sides:
  // normal on each side of the usual one.
  [[nodiscard]] double log_density(const Eigen::Vector3d& size_m) const;
};

// A kind of thing that homes have: one row of kinds.json.
struct Kind {
  std::string name;
  std::vector<std::string> labels;  // of networks, that mean it; none: networks do not name it
  std::optional<SizeDistribution> size;
  bool stands_on_floor = false;
  bool is_moved_about = false;               // by people, from day to day
  bool is_fixed = false;                     // to the house, or too heavy to be moved
  bool is_seat = false;                      // people sit on it
  bool is_surface = false;                   // things are put on it, and none into it
  bool is_spoken_of = true;                  // otherwise it only competes with what looks like it
  std::string room_type;                     // that the paper's home has it in; may be empty
  std::map<std::string, SpokenName> called;  // by language: "de"
};

// The rows of kinds.json, which is compiled in, and those that were added; by name.
[[nodiscard]] std::span<const Kind> standard_kinds();
// Absent for a word that somebody added to a home's vocabulary.
[[nodiscard]] const Kind* find_kind(std::string_view name);
// How large such things usually are, in one number, m; half a metre where nobody knows: the mean of
// the sides by their logarithms, and the longer level side.
[[nodiscard]] double usual_extent_m(std::string_view name);
[[nodiscard]] double typical_length_m(std::string_view name);
// As SizeDistribution::usual_m; half a metre each where nobody knows.
[[nodiscard]] Eigen::Vector3d usual_size_m(std::string_view name);

// How long things stay where they are, by whether they are carried about, are furniture or are
// fixed: the mean time, in days, until one is moved ("stays" of kinds.json).
struct StayTimes {
  double carried_days = 0, furniture_days = 0, fixed_days = 0;
};
[[nodiscard]] const StayTimes& stay_times();
// The probability that a thing of that name stands still where it stood some days (0 at least) ago,
// if things are moved at a constant rate: exp(-days / mean time). What nobody knows is taken for
// furniture.
[[nodiscard]] double probability_still_there(std::string_view name, double days);

// By name. Fails, naming the row, where a field is of another type or unknown, sizes are not
// positive and in order, or two rows have one name.
[[nodiscard]] Expected<std::vector<Kind>> parse_kinds(std::string_view json);
// Rows of somebody's own: each takes the place of the one of its name, or is added. A program does
// that once, before it asks for kinds. Fails as parse_kinds() does; then nothing is added.
[[nodiscard]] Expected<void> add_kinds(std::string_view json);

}  // namespace roomwise::objects
