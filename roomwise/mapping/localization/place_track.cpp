#include "roomwise/mapping/localization/place_track.h"

namespace roomwise::mapping {
namespace {

// Pictures that are farther apart hardly show the same to who walks or turns.
constexpr double kFollows_s = 2;

}  // namespace

Localization PlaceTrack::locate(const Localizer& localizer,
                                const motion::FrameMeasurements& measured,
                                const geometry::PinholeCamera& camera, double t_s) {
  const Query query{measured, camera};
  const bool follows = last_ && t_s > last_->t_s && t_s - last_->t_s < kFollows_s;
  if (!follows) {
    const Localization place = localizer.locate(query);
    if (place.found()) last_.emplace(Last{measured, place, t_s});
    return place;
  }
  const auto [place, carried] = localizer.follow({last_->measured, camera}, last_->place, query);
  if (place.found()) {
    last_.emplace(Last{measured, place, t_s});
  } else if (carried && carried->found()) {
    // Nobody is told, but it is what the next one is held against.
    last_.emplace(Last{measured, *carried, t_s});
  }
  return place;
}

}  // namespace roomwise::mapping
