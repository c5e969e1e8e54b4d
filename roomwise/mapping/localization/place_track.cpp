#include "roomwise/mapping/localization/place_track.h"

namespace roomwise::mapping {
namespace {

// Pictures that are farther apart hardly show the same to who walks or turns, s.
constexpr double kFollows_s = 2;
// Nobody who carries a camera through a home is faster (and places are known less exactly).
constexpr double kReach_m = 0.5, kReach_m_s = 1.5;
// So long after it was seen last, s, a rival is forgotten.
constexpr double kRival_s = 10;

// From as near, and facing as alike, what deceives does so again.
bool are_apart(const Localization& a, const Localization& b) {
  constexpr double kApart_m = 0.25, kApart_rad = 0.25;
  const geometry::RigidTransform between = a.world_from_camera.inverse() * b.world_from_camera;
  return between.translation.norm() > kApart_m ||
         between.rotation.angularDistance(Eigen::Quaterniond::Identity()) > kApart_rad;
}

}  // namespace

Localization PlaceTrack::locate(const Localizer& localizer, motion::FrameMeasurements measured,
                                const geometry::PinholeCamera& camera, double t_s) {
  const Query query{measured, camera};
  if (rival_ && !(t_s > rival_->t_s && t_s - rival_->t_s < kRival_s)) rival_.reset();
  const bool follows = last_ && t_s > last_->t_s && t_s - last_->t_s < kFollows_s;
  Localizer::Followed now;
  if (follows) {
    now = localizer.follow({last_->measured, camera}, last_->place, query);
  } else {
    now.place = now.alone = localizer.locate(query);
  }
  if (follows && !now.carried && is_out_of_reach(now.alone, t_s)) {
    now.place.status = LocalizationStatus::kAmbiguous;
  }
  if (rival_ && now.alone.found() && !now.place.is_carried) {
    if (!are_apart(rival_->place, now.alone)) {
      rival_->t_s = t_s;
      now.place.status = LocalizationStatus::kAmbiguous;
    } else if (localizer.agree({rival_->measured, camera}, rival_->place, query, now.alone)) {
      now.place = now.alone;
    }
  }
  if (now.place.found()) {
    if (!now.place.is_carried) rival_.reset();
    last_.emplace(Last{std::move(measured), now.place, t_s});
    return now.place;
  }
  if (now.alone.found() && (!rival_ || are_apart(rival_->place, now.alone))) {
    rival_.emplace(Last{measured, now.alone, t_s});
  }
  // Nobody is told, but it is what the next one is held against.
  if (now.carried && now.carried->found()) {
    last_.emplace(Last{std::move(measured), *now.carried, t_s});
  }
  return now.place;
}

bool PlaceTrack::is_out_of_reach(const Localization& place, double t_s) const {
  const double apart_m =
      (place.world_from_camera.translation - last_->place.world_from_camera.translation).norm();
  return place.found() && apart_m > kReach_m + kReach_m_s * (t_s - last_->t_s);
}

}  // namespace roomwise::mapping
