#include "roomwise/guide/led/guidance_options.h"

#include <utility>

namespace roomwise::guide {

Expected<void> GuidanceOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(plan.validate());
  if (!(announce_to_m > 0 && announce_from_m > announce_to_m)) {
    return fail("announce_from_m is {} and announce_to_m {}; expected the first to be larger",
                announce_from_m, announce_to_m);
  }
  for (const auto& [name, value] :
       {std::pair{"reassure_m", reassure_m}, std::pair{"reassure_s", reassure_s},
        std::pair{"off_way_m", off_way_m}, std::pair{"off_way_degrees", off_way_degrees},
        std::pair{"off_way_s", off_way_s}, std::pair{"lost_s", lost_s},
        std::pair{"lost_standing_s", lost_standing_s}, std::pair{"arrived_m", arrived_m},
        std::pair{"body_radius_m", body_radius_m}, std::pair{"remind_s", remind_s}}) {
    if (!(value > 0)) return fail("{} is {}; expected more than 0", name, value);
  }
  return {};
}

}  // namespace roomwise::guide
