#pragma once

#include <optional>

#include "roomwise/mapping/localization/localizer.h"

namespace roomwise::mapping {

// The places of pictures of one calibrated camera, one after the other. What a picture alone leaves
// open is answered by the motion since the last place; and a picture that alone tells of another
// place than that motion leads to (a wallpaper of the other side of the home) has none.
class PlaceTrack {
 public:
  // As Localizer::locate(). Times, s, of the camera's clock; a picture long after the last place,
  // or before it, stands alone. The localizer must be the same, or forget() called.
  [[nodiscard]] Localization locate(const Localizer& localizer,
                                    const motion::FrameMeasurements& measured,
                                    const geometry::PinholeCamera& camera, double t_s);
  void forget() { last_.reset(); }

 private:
  struct Last {
    motion::FrameMeasurements measured;
    Localization place;
    double t_s = 0;
  };
  std::optional<Last> last_;
};

}  // namespace roomwise::mapping
