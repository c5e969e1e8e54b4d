#pragma once

#include <array>
#include <string_view>

#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {

// What the variance of a box's middle along one of its axes is a sum of, m²; each has a weight,
// which is not negative (InstanceModel).
constexpr std::array<std::string_view, 4> kVarianceNames = {
    "constant",           // 1 m²
    "jackknife",          // of single pictures (Candidate::jackknife_m)
    "extent",             // square of what was seen along the axis
    "off usual extent"};  // square of how far that is from what such things usually have
using VarianceTerms = std::array<double, kVarianceNames.size()>;

// Along x, y and z of the candidate's box.
[[nodiscard]] std::array<VarianceTerms, 3> variance_terms(const Candidate& candidate);

}  // namespace roomwise::objects
