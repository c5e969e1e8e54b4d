#pragma once

#include <set>
#include <string>
#include <vector>

#include "laboratory/trials/localization_evaluation.h"

// Fits the model that says which poses of pictures without depth are right (mapping::PoseModel),
// from walks whose truth is known and from pictures of other homes.
namespace roomwise::trials {

// What pictures of one walk were answered on one home.
struct PoseCase {
  std::string name;
  std::set<std::string> sources;  // cases that share one share pictures and are left out together
  bool is_real = false;
  std::vector<mapping::PoseEvidence> evidence;  // of each picture that has a pose
  std::vector<bool> is_right;
  std::size_t pictures = 0;  // with those that have none
};
// `elsewhere`: the pictures are not of this home, so that no pose is right.
[[nodiscard]] PoseCase pose_case(std::string name, std::set<std::string> sources, bool is_real,
                                 bool elsewhere, const std::vector<LocalizationTrial>& trials);

// How many poses are answers, and how many of these are wrong.
struct PoseCounts {
  std::size_t pictures = 0, right = 0, wrong = 0;
};
[[nodiscard]] PoseCounts counts_of(const PoseCase& of, const mapping::PoseModel& model);
// The naive way: 40 inliers, and two thirds of them at most for a rival.
[[nodiscard]] PoseCounts naive_counts(const PoseCase& of);

// Those that share no source with one of them.
[[nodiscard]] std::vector<PoseCase> of_other_sources(const std::vector<PoseCase>& cases,
                                                     const PoseCase& one);

// Real cases weigh as much together as simulated ones. The threshold is the lowest with which, of
// poses of cases left out of the fit, no larger share of what is answered is wrong than with the
// naive way. Fails where no pose is right or none is wrong, or a case is of the sources of all.
[[nodiscard]] Expected<mapping::PoseModel> fit_poses(const std::vector<PoseCase>& cases);

}  // namespace roomwise::trials
