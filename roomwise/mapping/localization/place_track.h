#pragma once

#include <optional>

#include "roomwise/mapping/localization/localizer.h"

namespace roomwise::mapping {

// The places of pictures of one calibrated camera, one after the other. What a picture alone leaves
// open is answered by the motion since the last place. A picture that alone tells of another place
// than that motion leads to, or that nobody could have reached (the same wallpaper at the other
// side of the home), has none, nor has what looks the same from there later. If it was the first
// place that was wrong, a second such picture from another point of view that agrees with it ends
// that.
class PlaceTrack {
 public:
  // As Localizer::locate(). Times, s, of the camera's clock; a picture long after the last place,
  // or before it, stands alone. The localizer must be the same, or forget() called.
  [[nodiscard]] Localization locate(const Localizer& localizer, motion::FrameMeasurements measured,
                                    const geometry::PinholeCamera& camera, double t_s);
  void forget() {
    last_.reset();
    rival_.reset();
  }

 private:
  struct Last {
    motion::FrameMeasurements measured;
    Localization place;
    double t_s = 0;
  };
  [[nodiscard]] bool is_out_of_reach(const Localization& place, double t_s) const;

  std::optional<Last> last_;
  std::optional<Last> rival_;  // what a picture alone told that the motion does not lead to
};

}  // namespace roomwise::mapping
