#include "roomwise/objects/kinds/kinds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "roomwise/base/encodings.h"
#include "roomwise/base/own_data.h"
#include "roomwise/objects/built_in_data.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

SizeDistribution size_of(const json& size) {
  const auto sides = [&](const char* which) -> Vector3d {
    return Vector3d(size.at(which).get<std::array<double, 3>>().data());
  };
  return {sides("least"), sides("usual"), sides("most")};
}

// The row's fields; what is not given stays.
Kind kind_of(const json& row) {
  Kind kind;
  row.at("name").get_to(kind.name);
  for (const auto& [field, value] : row.items()) {
    if (field == "labels") value.get_to(kind.labels);
    if (field == "size_m") kind.size = size_of(value);
    if (field == "on_floor") value.get_to(kind.stands_on_floor);
    if (field == "moves") value.get_to(kind.is_moved_about);
    if (field == "fixed") value.get_to(kind.is_fixed);
    if (field == "seat") value.get_to(kind.is_seat);
    if (field == "surface") value.get_to(kind.is_surface);
    if (field == "spoken") value.get_to(kind.is_spoken_of);
    if (field == "room_type") value.get_to(kind.room_type);
    if (field == "called") value.get_to(kind.called);
  }
  return kind;
}

Expected<void> check_fields(const json& row) {
  static const std::set<std::string> kFields{"name",   "labels",    "size_m", "on_floor",
                                             "moves",  "fixed",     "seat",   "surface",
                                             "spoken", "room_type", "called"};
  for (const auto& [field, value] : row.items()) {
    if (!kFields.contains(field)) return fail("there is no field \"{}\"", field);
  }
  return {};
}

bool is_ordered(const SizeDistribution& size) {
  return (size.min_m.array() > 0).all() && (size.min_m.array() < size.usual_m.array()).all() &&
         (size.usual_m.array() < size.max_m.array()).all();
}

constexpr std::size_t kMaxName = 100;

bool is_name(std::string_view name) {
  return name.find_first_not_of(' ') != std::string_view::npos && name.size() <= kMaxName &&
         is_plain_text(name);
}

StayTimes parse_stay_times(std::string_view text) {
  const json stays = json::parse(text).at("stays");
  return {stays.at("carried_days").get<double>(), stays.at("furniture_days").get<double>(),
          stays.at("fixed_days").get<double>()};
}

std::vector<Kind>& all_kinds() {
  static std::vector<Kind> kinds = own_data(parse_kinds(kKindsJson));
  return kinds;
}

}  // namespace

void from_json(const json& members, SpokenName& name) {
  for (const auto& [member, content] : members.items()) {
    if (member == "name") {
      content.get_to(name.name);
    } else if (member == "class") {
      content.get_to(name.word_class);
    } else if (member == "also") {
      content.get_to(name.also);
    } else {
      content.get_to(name.forms[member]);
    }
  }
}

double SizeDistribution::log_density(const Vector3d& size_m) const {
  double log_density = 0;
  for (int side = 0; side < 3; ++side) {
    // From the usual size to the least or the most are two standard deviations.
    const double below = std::log(usual_m[side] / min_m[side]) / 2;
    const double above = std::log(max_m[side] / usual_m[side]) / 2;
    const double off = std::log(size_m[side] / usual_m[side]);
    const double z = off / (off < 0 ? below : above);
    log_density -= z * z / 2 + std::log(std::sqrt(std::numbers::pi / 2) * (below + above));
  }
  return log_density;
}

Expected<std::vector<Kind>> parse_kinds(std::string_view text) {
  std::vector<Kind> kinds;
  try {
    const auto parsed = json::parse(text);
    for (const json& row : parsed.at("kinds")) {
      const Kind& kind = kinds.emplace_back(kind_of(row));
      if (!is_name(kind.name)) {
        return fail("the kind in row {}: its name must be one line of text, {} bytes at most",
                    kinds.size(), kMaxName);
      }
      if (auto checked = check_fields(row); !checked) {
        return Unexpected(
            std::move(checked).error().with_context(fmt::format("kind \"{}\"", kind.name)));
      }
      if (kind.is_moved_about && kind.is_fixed) {
        return fail("kind \"{}\": moves and is fixed; expected one of both at most", kind.name);
      }
      if (kind.size && !is_ordered(*kind.size)) {
        return fail("kind \"{}\": size_m must be positive, and least < usual < most", kind.name);
      }
    }
  } catch (const json::exception& error) {
    return fail("the kind in row {}: {}", kinds.size() + 1, error.what());
  }
  std::ranges::sort(kinds, {}, &Kind::name);
  const auto twice = std::ranges::adjacent_find(kinds, {}, &Kind::name);
  if (twice != kinds.end()) return fail("kind \"{}\" has two rows", twice->name);
  return kinds;
}

Expected<void> add_kinds(std::string_view text) {
  ROOMWISE_TRY(std::vector<Kind> added, parse_kinds(text));
  std::vector<Kind>& kinds = all_kinds();
  for (Kind& kind : added) {
    const auto place = std::ranges::lower_bound(kinds, kind.name, {}, &Kind::name);
    if (place != kinds.end() && place->name == kind.name) {
      *place = std::move(kind);
    } else {
      kinds.insert(place, std::move(kind));
    }
  }
  return {};
}

std::span<const Kind> standard_kinds() {
  return all_kinds();
}

const Kind* find_kind(std::string_view name) {
  const auto kinds = standard_kinds();
  const auto found = std::ranges::lower_bound(kinds, name, {}, &Kind::name);
  return found != kinds.end() && found->name == name ? &*found : nullptr;
}

const StayTimes& stay_times() {
  static const StayTimes times = parse_stay_times(kKindsJson);
  return times;
}

double probability_still_there(std::string_view name, double days) {
  const Kind* const kind = find_kind(name);
  const StayTimes& times = stay_times();
  const double mean_days = kind != nullptr && kind->is_moved_about ? times.carried_days
                           : kind != nullptr && kind->is_fixed     ? times.fixed_days
                                                                   : times.furniture_days;
  return std::exp(-days / mean_days);
}

Vector3d usual_size_m(std::string_view name) {
  constexpr double kUnknown_m = 0.5;
  const Kind* kind = find_kind(name);
  const bool is_known = kind != nullptr && kind->size;
  return is_known ? kind->size->usual_m : Vector3d::Constant(kUnknown_m);
}

double typical_length_m(std::string_view name) {
  return usual_size_m(name).x();
}

double usual_extent_m(std::string_view name) {
  return std::cbrt(usual_size_m(name).prod());
}

}  // namespace roomwise::objects
