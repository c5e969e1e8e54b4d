#include "laboratory/trials/change_evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "laboratory/trials/true_objects.h"
#include "laboratory/trials/truth_evaluation.h"

namespace roomwise::trials {
namespace {

using simulation::ObjectTruth;

constexpr double kNear_m = 0.2;
constexpr double kMinShownShare = 0.005;                         // of the picture
constexpr std::ptrdiff_t kWellSeenBefore = 4, kWellSeenNow = 3;  // frames

using ByName = std::map<std::string, ObjectTruth>;

Expected<ByName> read_by_name(const std::filesystem::path& recording) {
  ROOMWISE_TRY(auto objects, simulation::read_objects_truth(recording / "objects.json"));
  ByName by_name;
  for (ObjectTruth& object : objects) by_name[object.name] = std::move(object);
  return by_name;
}

const ObjectTruth* find_thing(const ByName& things, const std::string& name) {
  const auto at = things.find(name);
  return at == things.end() ? nullptr : &at->second;
}

bool is_seen_in(const ObjectTruth& object, std::ptrdiff_t min_frames) {
  return std::ranges::count_if(object.seen, [](const simulation::ObjectObservation& seen) {
           return seen.share >= kMinShownShare;
         }) >= min_frames;
}

// All that changed, with a word for it or without; what has no word is not expected.
std::vector<TrueChange> true_changes(const ByName& before, const ByName& now, double min_shift_m) {
  std::set<std::string> names;
  for (const auto& [name, object] : before) names.insert(name);
  for (const auto& [name, object] : now) names.insert(name);
  std::vector<TrueChange> changes;
  for (const std::string& name : names) {
    const ObjectTruth* was = find_thing(before, name);
    const ObjectTruth* is = find_thing(now, name);
    TrueChange change;
    change.name = name;
    change.label = (was != nullptr ? was : is)->label;
    if (was != nullptr && is != nullptr) {
      change.shift_m = (was->center_m - is->center_m).norm();
      if (change.shift_m < min_shift_m) continue;
      change.state = objects::ChangeState::kMoved;
    } else if (was != nullptr) {
      change.state = objects::ChangeState::kRemoved;
    }
    change.is_expected = (was == nullptr || is_seen_in(*was, kWellSeenBefore)) &&
                         (is == nullptr || is_seen_in(*is, kWellSeenNow));
    changes.push_back(std::move(change));
  }
  return changes;
}

// From the middle of a box to a true thing, m; infinite without one.
double distance_m(const std::optional<geometry::OrientedBox>& box_world, const ObjectTruth* thing,
                  const geometry::RigidTransform& truth_from_world) {
  if (!box_world || thing == nullptr) return std::numeric_limits<double>::infinity();
  return box_of(*thing).distance_m(truth_from_world * box_world->center());
}

bool may_be_called(const ObjectTruth& thing, const std::string& name,
                   const objects::ObjectVocabulary& vocabulary) {
  const auto words = in_words(thing, vocabulary);
  return words && (words->kind == name || words->also_called.contains(name));
}

// The change that an alarm is about: the nearest within reach, of its name if there is one.
TrueChange* find_cause(const pipeline::ThingUpdate& alarm, std::vector<TrueChange>& changes,
                       const ByName& before, const ByName& now,
                       const geometry::RigidTransform& truth_from_world,
                       const objects::ObjectVocabulary& vocabulary) {
  TrueChange* cause = nullptr;
  std::pair<bool, double> least{true, std::numeric_limits<double>::infinity()};
  for (TrueChange& change : changes) {
    const ObjectTruth* was = find_thing(before, change.name);
    const ObjectTruth* is = find_thing(now, change.name);
    const double off_m = std::min(distance_m(alarm.before, was, truth_from_world),
                                  distance_m(alarm.now, is, truth_from_world));
    if (off_m > kNear_m) continue;
    const std::pair cost{!may_be_called(was != nullptr ? *was : *is, alarm.name, vocabulary),
                         off_m};
    if (cost >= least) continue;
    least = cost;
    cause = &change;
  }
  return cause;
}

// A door's leaf that stands at another angle in the visit.
struct TurnedLeaf {
  simulation::Door before, now;
};
// The doors of one home come in one order.
Expected<std::vector<TurnedLeaf>> turned_leaves(const std::filesystem::path& mapped,
                                                const std::filesystem::path& visit) {
  constexpr double kMinTurn_rad = 0.1;
  ROOMWISE_TRY(const auto before, simulation::read_floor_plan(mapped / "floorplan.json"));
  ROOMWISE_TRY(const auto now, simulation::read_floor_plan(visit / "floorplan.json"));
  if (before.doors.size() != now.doors.size()) {
    return fail("{} and {} are walks through different homes", mapped.string(), visit.string());
  }
  std::vector<TurnedLeaf> turned;
  for (std::size_t i = 0; i < now.doors.size(); ++i) {
    const double turn_rad = now.doors[i].open_rad - before.doors[i].open_rad;
    if (now.doors[i].has_leaf && std::abs(turn_rad) >= kMinTurn_rad) {
      turned.push_back({before.doors[i], now.doors[i]});
    }
  }
  return turned;
}

// Whether a point is near the leaf, m aside. The plan does not say at which end the hinge is, nor
// to which side the leaf turns: any will do.
bool is_at_leaf(const Eigen::Vector3d& point_truth, const simulation::Door& door) {
  constexpr double kAside_m = 0.2;
  const double width_m = door.opening.width_m;
  if (point_truth.z() > door.opening.top_m + kAside_m) return false;
  const Eigen::Vector2d along =
      door.opening.along_x ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
  const Eigen::Vector2d across(-along.y(), along.x());
  for (const double end : {-0.5, 0.5}) {
    const Eigen::Vector2d hinge = door.opening.center + end * width_m * along;
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d leaf = std::cos(door.open_rad) * (end < 0 ? 1 : -1) * along +
                                   std::sin(door.open_rad) * side * across;
      const Eigen::Vector2d away = point_truth.head<2>() - hinge;
      const double on_leaf_m = std::clamp(leaf.dot(away), 0.0, width_m);
      if ((away - on_leaf_m * leaf).norm() <= kAside_m) return true;
    }
  }
  return false;
}

// Judges what changed without a name.
void judge_unnamed(const pipeline::HomeUpdate& update, std::vector<TrueChange>& changes,
                   const ByName& before, const ByName& now, std::span<const TurnedLeaf> leaves,
                   const geometry::RigidTransform& truth_from_world, ChangeEvaluation& result) {
  for (const pipeline::UnnamedChange& alarm : update.unnamed) {
    const Eigen::Vector3d middle = truth_from_world * alarm.box_world.center();
    const auto off_m = [&](const TrueChange& change) {
      return distance_m(alarm.box_world, find_thing(alarm.is_new ? now : before, change.name),
                        truth_from_world);
    };
    const auto nearest = std::ranges::min_element(changes, {}, off_m);
    if (nearest != changes.end() && off_m(*nearest) <= kNear_m) {
      nearest->is_noticed_unnamed = true;
      ++result.unnamed_right;
    } else if (std::ranges::any_of(leaves, [&](const TurnedLeaf& leaf) {
                 return is_at_leaf(middle, alarm.is_new ? leaf.now : leaf.before);
               })) {
      ++result.unnamed_doors;
    } else {
      const Eigen::Vector3d& size = alarm.box_world.size_m;
      result.unnamed_wrong.push_back(fmt::format(
          "{} {:.2f} x {:.2f} x {:.2f} m at {:.2f} {:.2f} {:.2f} m", alarm.is_new ? "new" : "gone",
          size.x(), size.y(), size.z(), middle.x(), middle.y(), middle.z()));
    }
  }
}

// The names of the true things that the home had found, each the nearest to one of its things.
std::set<std::string> known_things(const pipeline::HomeUpdate& update, const ByName& before,
                                   const geometry::RigidTransform& truth_from_world,
                                   const objects::ObjectVocabulary& vocabulary) {
  std::set<std::string> known;
  for (const pipeline::ThingUpdate& thing : update.things) {
    double min_m = kNear_m;
    std::string nearest;
    for (const auto& [name, truth] : before) {
      const double off_m = distance_m(thing.before, &truth, truth_from_world);
      if (off_m > min_m || !may_be_called(truth, thing.name, vocabulary)) continue;
      min_m = off_m;
      nearest = name;
    }
    if (!nearest.empty()) known.insert(nearest);
  }
  return known;
}

bool is_noticed(const TrueChange& change) {
  return !change.noticed_as.empty();
}

std::size_t count_expected(std::span<const TrueChange> changes, auto is_counted) {
  return static_cast<std::size_t>(std::ranges::count_if(
      changes, [&](const TrueChange& change) { return change.is_expected && is_counted(change); }));
}

}  // namespace

std::size_t ChangeEvaluation::expected() const {
  return count_expected(changes, [](const TrueChange&) { return true; });
}
std::size_t ChangeEvaluation::noticed() const {
  return count_expected(changes, is_noticed);
}
std::size_t ChangeEvaluation::noticed_with_unnamed() const {
  return count_expected(changes, [](const TrueChange& change) {
    return change.is_noticed_unnamed || is_noticed(change);
  });
}
std::size_t ChangeEvaluation::known() const {
  return count_expected(changes, [](const TrueChange& change) { return change.was_known; });
}
std::size_t ChangeEvaluation::known_noticed() const {
  return count_expected(
      changes, [](const TrueChange& change) { return change.was_known && is_noticed(change); });
}

Expected<ChangeEvaluation> evaluate_changes(const home::Home& home,
                                            const std::filesystem::path& mapped,
                                            const std::filesystem::path& visit,
                                            const pipeline::HomeUpdate& update,
                                            double min_shift_m) {
  ROOMWISE_RETURN_IF_ERROR(mapped_walk(home, mapped));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, mapped));
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const ByName before, read_by_name(mapped));
  ROOMWISE_TRY(const ByName now, read_by_name(visit));
  ChangeEvaluation result;
  std::vector<TrueChange> changes = true_changes(before, now, min_shift_m);
  const auto known = known_things(update, before, truth_from_world, concepts.vocabulary);
  for (TrueChange& change : changes) change.was_known = known.contains(change.name);
  for (const pipeline::ThingUpdate& thing : update.things) {
    if (!thing.is_changed()) {
      ++result.unchanged;
      continue;
    }
    const std::string alarm =
        fmt::format("{} {}", thing.is_new ? "new" : objects::to_string(thing.state), thing.name);
    if (TrueChange* cause =
            find_cause(thing, changes, before, now, truth_from_world, concepts.vocabulary)) {
      cause->noticed_as.push_back(alarm);
      ++result.right;
    } else {
      result.wrong.push_back(alarm);
    }
  }
  ROOMWISE_TRY(const auto leaves, turned_leaves(mapped, visit));
  judge_unnamed(update, changes, before, now, leaves, truth_from_world, result);
  for (TrueChange& change : changes) {
    const ObjectTruth* thing = find_thing(before, change.name);
    const auto words =
        in_words(thing != nullptr ? *thing : now.at(change.name), concepts.vocabulary);
    if (words && words->is_expected) result.changes.push_back(std::move(change));
  }
  return result;
}

}  // namespace roomwise::trials
