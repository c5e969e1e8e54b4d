#include "roomwise/evaluation/errors/object_error.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "roomwise/evaluation/statistics/quantile.h"

namespace roomwise::evaluation {
namespace {

// All pairs that may belong together, the closest first.
std::vector<ObjectMatch> candidates(std::span<const TrueObject> truth,
                                    std::span<const FoundObject> found, double max_distance_m) {
  std::vector<ObjectMatch> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t f = 0; f < found.size(); ++f) {
      if (truth[t].kind != found[f].kind && !truth[t].also_called.contains(found[f].kind)) continue;
      const double from_box_m = truth[t].box.distance_m(found[f].position);
      if (from_box_m > max_distance_m) continue;
      const double from_center_m = (truth[t].box.center() - found[f].position).norm();
      pairs.push_back({t, f, from_box_m, from_center_m});
    }
  }
  std::ranges::sort(pairs, {}, [](const ObjectMatch& pair) {
    return std::tuple(pair.from_box_m, pair.from_center_m, pair.truth, pair.found);
  });
  return pairs;
}

bool is_held(std::span<const TrueObject> truth, const FoundObject& found) {
  constexpr double kReach_m = 0.1;
  return std::ranges::any_of(truth, [&](const TrueObject& thing) {
    return thing.holds.contains(found.kind) && thing.box.distance_m(found.position) <= kReach_m;
  });
}

double quantile_of(std::span<const ObjectMatch> matches, double ObjectMatch::*value, double share) {
  std::vector<double> values;
  for (const ObjectMatch& match : matches) values.push_back(match.*value);
  return quantile(std::move(values), share);
}

}  // namespace

ObjectCounts& ObjectCounts::operator+=(const ObjectCounts& other) {
  matched += other.matched;
  beyond += other.beyond;
  missed += other.missed;
  duplicates += other.duplicates;
  wrong += other.wrong;
  return *this;
}

double ObjectErrors::from_box_quantile_m(double share) const {
  return quantile_of(matches, &ObjectMatch::from_box_m, share);
}

double ObjectErrors::from_center_quantile_m(double share) const {
  return quantile_of(matches, &ObjectMatch::from_center_m, share);
}

Expected<ObjectErrors> object_errors(std::span<const TrueObject> truth,
                                     std::span<const FoundObject> found, double max_distance_m) {
  if (!(max_distance_m > 0)) {
    return fail("max_distance_m = {} must be positive", max_distance_m);
  }
  ObjectErrors errors;
  std::vector<bool> truth_used(truth.size()), found_used(found.size());
  std::vector<std::optional<ObjectMatch>> nearest(found.size());
  for (const ObjectMatch& pair : candidates(truth, found, max_distance_m)) {
    if (!nearest[pair.found]) nearest[pair.found] = pair;
    if (truth_used[pair.truth] || found_used[pair.found]) continue;
    truth_used[pair.truth] = found_used[pair.found] = true;
    errors.matches.push_back(pair);
  }
  std::ranges::sort(errors.matches, {}, &ObjectMatch::truth);

  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!truth_used[t] && !truth[t].is_expected) continue;
    if (!truth_used[t]) errors.missed.push_back(t);
    ObjectCounts& counts = errors.by_kind[truth[t].kind];
    ++(!truth_used[t] ? counts.missed : truth[t].is_expected ? counts.matched : counts.beyond);
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (found_used[f]) continue;
    if (nearest[f]) {
      errors.duplicates.push_back(*nearest[f]);
      ++errors.by_kind[truth[nearest[f]->truth].kind].duplicates;
    } else if (!is_held(truth, found[f])) {
      errors.wrong.push_back(f);
      ++errors.by_kind[found[f].kind].wrong;
    }
  }
  for (const auto& [kind, counts] : errors.by_kind) {
    errors.all += counts;
  }
  return errors;
}

}  // namespace roomwise::evaluation
