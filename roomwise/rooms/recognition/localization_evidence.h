#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/mapping/localization/localization.h"
#include "roomwise/rooms/layout/room_layout.h"
#include "roomwise/rooms/recognition/room_classifier.h"
#include "roomwise/rooms/recognition/room_model.h"

namespace roomwise::rooms {

// What looking for pictures on the home's map tells of the room in which they were taken.
struct LocalizationEvidence {
  // Of each room, every room alike beforehand, by the place alone; they add up to 1. All alike
  // where there is no place, or none of these rooms is there.
  Eigen::VectorXd probabilities;
  // How much oftener the localiser answers so to pictures of these rooms than to others: the
  // logarithm of the ratio. Above 0 it speaks for one of these rooms.
  double log_likelihood_ratio = 0;
  std::string why;  // for people: "its place on the map is in kitchen"
};

// From the localiser's answer. A pose shares its probability out among the rooms whose floor is
// around it, as wide as it is uncertain; near a doorway that is several. What of it lies on the
// floor of a learned room speaks for these rooms, what lies on that of a room that was not learned,
// or that nobody named, against all of them, more than that there is no place at all. A pose
// outside every floor tells no room and speaks neither for nor against them. That there is none
// speaks against them if the pictures have depth; without depth too many have none.
//
// `layout` may be absent: then no room is told. `rooms`: the learned ones, by name; one of them
// without floor is none that the place tells.
[[nodiscard]] LocalizationEvidence localization_evidence(const mapping::Localization& answer,
                                                         bool has_depth,
                                                         const fusion::GravityAlignedFrame& frame,
                                                         const std::optional<RoomLayout>& layout,
                                                         std::span<const std::string> rooms);

// The same of two pictures that were taken shortly after one another, both with depth or neither:
// of the room in which the second was taken. Where it has no place, the first's tells the room
// nearly as surely; where the two contradict each other, neither does. Whether this is their home
// both say, as much as two pictures of one place tell more than one (effective_sample_size()): a
// place that one of them seems to have, and the other has not, says little.
[[nodiscard]] LocalizationEvidence localization_evidence(const mapping::PairLocalization& answers,
                                                         bool has_depth,
                                                         const fusion::GravityAlignedFrame& frame,
                                                         const std::optional<RoomLayout>& layout,
                                                         std::span<const std::string> rooms);

// Whether a place, or that there is none, may change what is said of pictures (combined): they
// leave the room open, or are not so familiar that it would be named without a place, too.
[[nodiscard]] bool place_may_tell(const PictureEvidence& pictures, const RoomModel& model);

// What pictures (combined) and their place tell together, by Bayes' rule: probabilities multiply,
// and so do the odds of being in this home. The familiarity of the pictures alone is bounded from
// below by RoomModel::reject_log_odds, so that a sure place in one of the rooms makes any
// picture familiar, and any pair where both have one.
[[nodiscard]] PictureEvidence with_place(const PictureEvidence& pictures,
                                         const LocalizationEvidence& place, const RoomModel& model);

}  // namespace roomwise::rooms
