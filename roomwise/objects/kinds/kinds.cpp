#include "roomwise/objects/kinds/kinds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "roomwise/objects/built_in_data.h"

namespace roomwise::objects {

Expected<std::vector<Kind>> parse_kinds(std::string_view json) {
  std::vector<Kind> kinds;
  try {
    const auto parsed = nlohmann::json::parse(json);
    for (const auto& row : parsed.at("kinds")) {
      Kind& kind = kinds.emplace_back();
      row.at("name").get_to(kind.name);
      row.at("labels").get_to(kind.labels);
      const auto size = row.at("size_m").get<std::array<double, 3>>();
      if (!(std::ranges::min(size) > 0)) {
        return fail("kind \"{}\": size_m must be positive", kind.name);
      }
      kind.size_m = {size[0], size[1], size[2]};
      row.at("on_floor").get_to(kind.stands_on_floor);
      row.at("moves").get_to(kind.is_moved_about);
      kind.is_spoken_of = row.value("spoken", true);
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("kind {}: {}", kinds.size(), error.what());
  }
  std::ranges::sort(kinds, {}, &Kind::name);
  const auto twice = std::ranges::adjacent_find(kinds, {}, &Kind::name);
  if (twice != kinds.end()) return fail("kind \"{}\" has two rows", twice->name);
  return kinds;
}

std::span<const Kind> standard_kinds() {
  static const std::vector<Kind> kKinds = [] {
    auto kinds = parse_kinds(kKindsJson);
    if (!kinds) std::abort();  // the program's own data, which a test reads
    return *std::move(kinds);
  }();
  return kKinds;
}

const Kind* find_kind(std::string_view name) {
  const auto kinds = standard_kinds();
  const auto found = std::ranges::lower_bound(kinds, name, {}, &Kind::name);
  return found != kinds.end() && found->name == name ? &*found : nullptr;
}

constexpr double kUnknown_m = 0.5;

Eigen::Vector3d usual_size_m(std::string_view name) {
  const Kind* kind = find_kind(name);
  return kind == nullptr ? Eigen::Vector3d::Constant(kUnknown_m) : kind->size_m;
}

double typical_length_m(std::string_view name) {
  return usual_size_m(name).x();
}

double usual_extent_m(std::string_view name) {
  return std::cbrt(usual_size_m(name).prod());
}

}  // namespace roomwise::objects
