#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include "roomwise/objects/instances/world_observation.h"

namespace roomwise::objects {
namespace {

// Of an observation's cells, those that the group has too.
constexpr double kSameSpace = 0.5;
constexpr double kSameGroup = 0.4;  // of the smaller group's cells
// Of a detector's box, those that something measured has.
constexpr double kAgrees = 0.75;
constexpr double kMaxConflicts = 0.25;  // of the key-frames that show both groups apart
// A group's own cells are those that this share of its observations shows; others are a wall behind
// it in one picture and not in the next.
constexpr double kCoreShare = 0.15;

struct Group {
  std::string class_name;
  DetectionSource source = DetectionSource::kDetector;
  ObservationCluster members;
  std::size_t own = 0;                     // members of its source
  std::unordered_map<VoxelKey, int> hits;  // by these

  void add(std::size_t index, const WorldObservation& observation) {
    members.push_back(index);
    if (observation.detection->source != source) return;
    ++own;
    for (const VoxelKey voxel : observation.voxels) ++hits[voxel];
  }
  [[nodiscard]] bool has(VoxelKey voxel) const {
    const auto found = hits.find(voxel);
    return found != hits.end() && found->second >= kCoreShare * static_cast<double>(own);
  }
  // Or the cell beside it.
  [[nodiscard]] bool is_near(VoxelKey voxel) const {
    return has(voxel) || std::ranges::any_of(face_neighbors(voxel),
                                             [&](VoxelKey neighbor) { return has(neighbor); });
  }
  [[nodiscard]] std::vector<VoxelKey> core() const {
    std::vector<VoxelKey> core;
    for (const auto& [voxel, count] : hits) {
      if (has(voxel)) core.push_back(voxel);
    }
    std::ranges::sort(core);
    return core;
  }
};

// Whether they may be one group. What different finders say of a place competes or agrees later,
// as groups: the boxes of one are no measure for those of the other. But see confirms().
bool are_alike(const Group& group, const WorldObservation& other) {
  return group.class_name == other.detection->class_name && group.source == other.detection->source;
}

// Whether a detector's box may speak of what was measured, whose place it then takes no part in.
bool confirms(const Group& group, const WorldObservation& observation) {
  return group.source == DetectionSource::kProposal &&
         observation.detection->source == DetectionSource::kDetector &&
         observation.detection->class_name == group.class_name;
}

// The share of the cells that the group has, or their neighbours.
double share_in(std::span<const VoxelKey> voxels, const Group& group) {
  const auto shared =
      std::ranges::count_if(voxels, [&](VoxelKey voxel) { return group.is_near(voxel); });
  return static_cast<double>(shared) / static_cast<double>(std::max<std::size_t>(1, voxels.size()));
}

// Two boxes of one picture that are not one thing found twice.
bool are_apart(const network::PixelBox& a, const network::PixelBox& b) {
  constexpr float kOneInTheOther = 0.6F;
  return network::intersection(a, b).area() < kOneInTheOther * std::min(a.area(), b.area());
}

bool conflicts(const Group& group, const WorldObservation& observation,
               std::span<const WorldObservation> observations) {
  return std::ranges::any_of(group.members, [&](std::size_t member) {
    return observations[member].keyframe == observation.keyframe &&
           are_apart(observations[member].detection->box, observation.detection->box);
  });
}

// The share of the less seen group's key-frames that show the two beside each other.
double conflict_share(const Group& a, const Group& b,
                      std::span<const WorldObservation> observations) {
  std::multimap<std::size_t, std::size_t> of_keyframe;
  std::set<std::size_t> keyframes_a, keyframes_b, apart;
  for (const std::size_t member : a.members) {
    of_keyframe.emplace(observations[member].keyframe, member);
    keyframes_a.insert(observations[member].keyframe);
  }
  for (const std::size_t member : b.members) {
    const std::size_t keyframe = observations[member].keyframe;
    keyframes_b.insert(keyframe);
    const auto [first, last] = of_keyframe.equal_range(keyframe);
    for (auto other = first; other != last; ++other) {
      if (are_apart(observations[other->second].detection->box,
                    observations[member].detection->box))
        apart.insert(keyframe);
    }
  }
  return static_cast<double>(apart.size()) /
         static_cast<double>(std::min(keyframes_a.size(), keyframes_b.size()));
}

// Joins the two groups of one name that share most, as long as there are such.
void merge_groups(std::vector<Group>& groups, std::span<const WorldObservation> observations) {
  while (true) {
    double most = kSameGroup;
    std::pair<std::size_t, std::size_t> best;
    for (std::size_t a = 0; a < groups.size(); ++a) {
      const auto core_a = groups[a].core();
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        if (!are_alike(groups[a], observations[groups[b].members.front()])) continue;
        const auto core_b = groups[b].core();
        const bool a_is_smaller = core_a.size() < core_b.size();
        const double shared =
            a_is_smaller ? share_in(core_a, groups[b]) : share_in(core_b, groups[a]);
        if (shared <= most || conflict_share(groups[a], groups[b], observations) > kMaxConflicts)
          continue;
        most = shared;
        best = {a, b};
      }
    }
    if (best.second == 0) return;
    for (const std::size_t member : groups[best.second].members) {
      groups[best.first].add(member, observations[member]);
    }
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(best.second));
  }
}

// The group that has most of the observation's cells, of those that may take it, from a share on;
// null where there is none.
template <typename MayTake>
Group* best_group(std::vector<Group>& groups, const WorldObservation& observation,
                  std::span<const WorldObservation> observations, double least,
                  const MayTake& may_take) {
  Group* best = nullptr;
  double most = least;
  for (Group& group : groups) {
    if (!may_take(group, observation)) continue;
    const double shared = share_in(observation.voxels, group);
    if (shared <= most || conflicts(group, observation, observations)) continue;
    most = shared;
    best = &group;
  }
  return best;
}

}  // namespace

std::vector<ObservationCluster> cluster_observations(
    std::span<const WorldObservation> observations) {
  std::vector<Group> groups;
  // What was measured comes first: a detector's boxes that agree with it are of it, though others
  // of its name stand beside it and pictures took them for one.
  std::vector<std::size_t> order(observations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_partition(order, [&](std::size_t i) {
    return observations[i].detection->source == DetectionSource::kProposal;
  });
  for (const std::size_t i : order) {
    const WorldObservation& observation = observations[i];
    Group* group = best_group(groups, observation, observations, kAgrees, confirms);
    if (group == nullptr) {
      group = best_group(groups, observation, observations, kSameSpace, are_alike);
    }
    if (group == nullptr) {
      group = &groups.emplace_back();
      group->class_name = observation.detection->class_name;
      group->source = observation.detection->source;
    }
    group->add(i, observation);
  }
  merge_groups(groups, observations);
  std::vector<ObservationCluster> members;
  for (Group& group : groups) {
    std::ranges::sort(group.members);  // observations stand in the order of quality
    members.push_back(std::move(group.members));
  }
  return members;
}

}  // namespace roomwise::objects
