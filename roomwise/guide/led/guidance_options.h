#pragma once

#include "roomwise/guide/way/plan.h"

namespace roomwise::guide {

struct GuidanceOptions {
  PlanOptions plan = {};
  // The next action is announced while it is so far ahead, m.
  double announce_from_m = 3, announce_to_m = 1.5;
  // Who walks hears something after so much, whichever comes first.
  double reassure_m = 5, reassure_s = 8;
  // Off the way: so far beside it or turned so far from it, for so long.
  double off_way_m = 1, off_way_degrees = 30, off_way_s = 2;
  // Without a pose, of who walks or was told to, who is told to stand and wait as long again, and
  // of who stands: the slow turn that is asked for then costs more than waiting for the next
  // picture that tells of one.
  double lost_s = 4, lost_standing_s = 8;
  // From a person's edge to a thing that is reached, and a person's radius seen from above, m.
  double arrived_m = 0.3, body_radius_m = 0.25;
  // Who stands where there is something to do hears of it again after so long, once.
  double remind_s = 8;

  [[nodiscard]] Expected<void> validate() const;
};

}  // namespace roomwise::guide
