#include "roomwise/mapping/localization/localizer.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "roomwise/motion/view_linearization.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// What neither inliers nor depth images show: the map's own error between key-frames, colour and
// depth out of step.
constexpr double kMapTranslation_m = 0.02;
constexpr double kMapHalfAngle = 0.5 * 0.006;

geometry::Matrix6d with_systematic_error(const geometry::Matrix6d& information) {
  return motion::with_systematic_error(information, kMapTranslation_m, kMapHalfAngle);
}

// How well a view's surfaces hold a camera in place along the direction in which they do least: the
// mean square of the normals' component along it; 1/3 at most. 0 before a wall, but for noise.
double min_normal_eigenvalue(const motion::RgbdPyramid& view) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double count = 0;
  for (const motion::SurfacePoint& point : motion::surface_points(view.levels.back(), 1)) {
    if (!point.has_normal) continue;
    const Eigen::Vector3d normal = point.normal.cast<double>();
    sum += normal * normal.transpose();
    ++count;
  }
  if (count == 0) return 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum / count, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0];
}

// What speaks for a pose found by shape: that its alignment fits, that the key-frames around agree
// with it in depth and pattern, and that several lead to it, of which each further one says less.
// The form was chosen on walks through simulated homes (docs/experiments/finding-a-picture.md).
double support(const Localization& pose, double rms) {
  constexpr double kResidualDoubtPerSupport =
      0.6;  // what is left of a doubt after one witness more
  const double fit = 1 / std::max(0.5, rms);
  return fit * pose.agreement.overlap * std::pow(pose.agreement.agreeing, 4) *
         (1 - std::pow(kResidualDoubtPerSupport, pose.supporting_keyframes)) *
         (0.5 + std::max(0.0, pose.pattern_correlation));
}

// So few inliers are looked for that they may be no more than a weak hypothesis.
motion::MotionOptions with_weak_hypotheses(const LocalizerOptions& options) {
  motion::MotionOptions features = options.features;
  features.min_inliers = std::min(features.min_inliers, options.min_hypothesis_inliers);
  features.min_matches = std::min(features.min_matches, options.min_hypothesis_inliers);
  features.min_inlier_ratio = std::min(features.min_inlier_ratio, 0.04);
  return features;
}
bool is_weak_hypothesis(const motion::MotionOutcome& found, const motion::MotionOptions& features) {
  return found.inliers < features.min_inliers || found.matches < features.min_matches ||
         found.inliers < features.min_inlier_ratio * found.matches;
}

// The share of the cells of a grid over a picture that hold a match which the pose explains.
double coverage(std::span<const motion::PointObservation> observations,
                const RigidTransform& current_from_reference, const geometry::PinholeCamera& camera,
                double inlier_px) {
  constexpr int kCells = 8;  // along each side
  std::array<bool, kCells * kCells> holds_one{};
  const auto cell = [](double pixel, int pixels) {
    return std::clamp(static_cast<int>(kCells * pixel / pixels), 0, kCells - 1);
  };
  for (const motion::PointObservation& observation : observations) {
    const Eigen::Vector3d point = current_from_reference * observation.point_reference;
    const Eigen::Vector2d& pixel = observation.pixel_current;
    if (!(point.z() > 0) || (camera.project(point) - pixel).norm() >= inlier_px) continue;
    holds_one.at(static_cast<std::size_t>(kCells * cell(pixel.y(), camera.height) +
                                          cell(pixel.x(), camera.width))) = true;
  }
  return static_cast<double>(std::ranges::count(holds_one, true)) / holds_one.size();
}

// How much pattern and depth around a pose are the picture's.
double confirmation_score(const Localization& pose) {
  return pose.pattern_correlation * std::pow(pose.agreement.agreeing, 4);
}

}  // namespace

Localizer::Localizer(const LocalizerOptions& options) : options_(options) {}

Localizer::Localizer(const LocalizerOptions& options, LocalizerIndex index,
                     std::vector<PlacedKeyframe> keyframes, MeasureKeyframe measure)
    : options_(options),
      keyframes_(std::move(keyframes)),
      index_(std::move(index)),
      measure_(std::move(measure)) {}

void Localizer::add(Keyframe keyframe, const RigidTransform& world_from_keyframe) {
  index_.add(keyframe.measurements);
  keyframes_.push_back({keyframe.id, world_from_keyframe});
  held_.push_back(std::make_shared<const MeasuredKeyframe>(
      MeasuredKeyframe::of(std::move(keyframe.measurements))));
}

std::shared_ptr<const MeasuredKeyframe> Localizer::measured(std::size_t index) const {
  return index < held_.size() ? held_[index] : measure_(index);
}

bool Localizer::may_show_the_same(const RigidTransform& a, const RigidTransform& b) const {
  const RigidTransform apart = a.inverse() * b;
  return apart.distance_m() <= options_.place_m && apart.angle_rad() <= options_.place_rad;
}

bool Localizer::is_same(const RigidTransform& a, const RigidTransform& b) const {
  const RigidTransform apart = a.inverse() * b;
  return apart.distance_m() <= options_.same_m && apart.angle_rad() <= options_.same_rad;
}

// The key-frames from which nearly the same is seen as from a pose, the nearest first; a metre
// counts as a radian.
std::vector<std::size_t> Localizer::nearest(const Query& query, const RigidTransform& pose) const {
  constexpr std::size_t kMax = 4;
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    if (query.leaves_out(i) || !may_show_the_same(keyframes_[i].world_from_keyframe, pose))
      continue;
    const RigidTransform apart = keyframes_[i].world_from_keyframe.inverse() * pose;
    near.emplace_back(apart.distance_m() + apart.angle_rad(), i);
  }
  std::ranges::stable_sort(near, {}, [](const auto& one) { return one.first; });
  near.resize(std::min(near.size(), kMax));
  std::vector<std::size_t> keyframes;
  for (const auto& [distance, keyframe] : near) keyframes.push_back(keyframe);
  return keyframes;
}

motion::ViewAgreement Localizer::agreement_around(const Query& query,
                                                  const RigidTransform& pose) const {
  motion::ViewAgreement around;
  double overlaps = 0;
  for (const std::size_t i : nearest(query, pose)) {
    const auto keyframe = measured(i);
    if (!keyframe) continue;
    const motion::ViewAgreement one =
        motion::compare_views(keyframe->measurements.view(), query.measurements.view(),
                              keyframes_[i].world_from_keyframe.inverse() * pose);
    around.overlap = std::max(around.overlap, one.overlap);
    around.agreeing += one.overlap * one.agreeing;
    around.seen_through += one.overlap * one.seen_through;
    around.in_front += one.overlap * one.in_front;
    overlaps += one.overlap;
  }
  if (overlaps > 0) {
    around.agreeing /= overlaps;
    around.seen_through /= overlaps;
    around.in_front /= overlaps;
  }
  return around;
}

double Localizer::pattern_correlation_around(const Query& query, const motion::ViewPattern& pattern,
                                             const RigidTransform& pose) const {
  motion::PatternCorrelation pattern_correlation;
  for (const std::size_t i : nearest(query, pose)) {
    const auto keyframe = measured(i);
    if (!keyframe) continue;
    pattern_correlation += motion::compare_patterns(
        keyframe->measurements.view(), keyframe->pattern, query.measurements.view(), pattern,
        keyframes_[i].world_from_keyframe.inverse() * pose);
  }
  return pattern_correlation.value();
}

// Only where the key-frames around see enough of the same to say so.
bool Localizer::is_contradicted(const motion::ViewAgreement& agreement) const {
  return agreement.overlap >= options_.views.min_overlap &&
         (agreement.agreeing < options_.views.min_agreeing ||
          agreement.seen_through > options_.views.max_seen_through);
}

// So little depth that no comparison counts is as none.
bool Localizer::shows_depth(const Query& query) const {
  return query.measurements.view().has_depth(options_.views.min_overlap);
}

// Depth images are compared pixel by pixel, so they must be of cameras alike.
bool Localizer::can_compare_shapes(const Query& query) const {
  const motion::RgbdPyramid& view = query.measurements.view();
  if (!shows_depth(query) || query.lens || !index_.view_camera()) return false;
  const geometry::PinholeCamera& a = view.levels.back().camera;
  const geometry::PinholeCamera& b = *index_.view_camera();
  constexpr double kAlike = 0.02;
  return a.width == b.width && a.height == b.height && std::abs(a.fx / b.fx - 1) < kAlike &&
         std::abs(a.fy / b.fy - 1) < kAlike;
}

bool Localizer::is_precise(const Localization& found) const {
  return found.position_sigma_m() <= options_.max_position_sigma_m &&
         found.rotation_sigma_rad() <= options_.max_rotation_sigma_rad;
}

std::vector<Localizer::Place> Localizer::similar_places(const Query& query) const {
  std::vector<Place> places;
  for (const AppearanceIndex::Hit& hit :
       index_.appearances().find(query.measurements.features().features, 0, keyframes_.size(),
                                 options_.similar, query.left_out)) {
    const RigidTransform& pose = keyframes_[hit.id].world_from_keyframe;
    const auto known = std::ranges::find_if(places, [&](const Place& place) {
      return may_show_the_same(keyframes_[place.members.front()].world_from_keyframe, pose);
    });
    Place& place = known == places.end() ? places.emplace_back() : *known;
    place.members.push_back(hit.id);
    place.votes += hit.votes;
  }
  std::ranges::stable_sort(places, std::ranges::greater(), &Place::votes);
  places.resize(std::min(places.size(), options_.places));
  for (Place& place : places) {
    place.members.resize(std::min(place.members.size(), options_.together));
  }
  return places;
}

// The points of a place in the frame of its first key-frame. Of the points that one feature of the
// picture matches in several key-frames the most similar counts: the same point seen twice is no
// second inlier.
std::vector<motion::PointObservation> Localizer::match(const Place& place,
                                                       const Query& query) const {
  struct Best {
    float distance = std::numeric_limits<float>::infinity();
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
  };
  const motion::MeasuredFeatures& picture = query.measurements.features();
  std::vector<Best> best(picture.size());
  const RigidTransform first_from_world =
      keyframes_[place.members.front()].world_from_keyframe.inverse();
  for (const std::size_t member : place.members) {
    const auto keyframe = measured(member);
    if (!keyframe) continue;
    const motion::MeasuredFeatures& seen = keyframe->measurements.features();
    const RigidTransform first_from_member =
        first_from_world * keyframes_[member].world_from_keyframe;
    for (const features::Match& match :
         features::match_features(picture.features, seen.features, options_.features.matching)) {
      if (!seen.has_point(match.train) || match.distance >= best[match.query].distance) continue;
      best[match.query] = {match.distance, first_from_member * seen.points[match.train]};
    }
  }
  std::vector<motion::PointObservation> observations;
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (std::isinf(best[i].distance)) continue;
    observations.push_back({best[i].point, picture.pixels[i], picture.points[i].z()});
  }
  return observations;
}

// The picture's pose relative to the first key-frame of a place.
motion::LensMotion Localizer::pose_in(const Place& place,
                                      std::span<const motion::PointObservation> observations,
                                      const Query& query) const {
  const RandomStream random(options_.seed, {keyframes_[place.members.front()].id});
  const motion::MotionOptions options = with_weak_hypotheses(options_);
  if (query.lens) {
    return motion::estimate_motion_and_lens(observations, query.camera.width, query.camera.height,
                                            *query.lens, options, random);
  }
  return {motion::estimate_motion(observations, query.camera, options, random), {}};
}

// The picture's pose by the points of one place.
Localization Localizer::locate_in(const Place& place, const Query& query) const {
  Localization here;
  const PlacedKeyframe& first = keyframes_[place.members.front()];
  const auto observations = match(place, query);
  const auto [outcome, lens] = pose_in(place, observations, query);
  if (query.lens) here.lens = lens;
  here.keyframe = first.id;
  here.matches = outcome.matches;
  here.inliers = outcome.inliers;
  if (!outcome.found()) {
    here.status = LocalizationStatus::kNoMotion;
    return here;
  }
  geometry::PinholeCamera camera = query.camera;
  camera.distortion = {};  // observations are undistorted
  if (query.lens) camera = lens.camera(camera.width, camera.height);
  here.coverage = coverage(observations, outcome.pose.reference_from_current.inverse(), camera,
                           options_.features.inlier_px);
  here.world_from_camera = first.world_from_keyframe * outcome.pose.reference_from_current;
  here.information = with_systematic_error(outcome.pose.information);
  if (shows_depth(query)) refine(query, here);

  const motion::ViewAgreement& agreement = here.agreement;
  if (is_weak_hypothesis(outcome, options_.features)) {
    here.status = LocalizationStatus::kUnconfirmed;
  } else if (is_contradicted(agreement)) {
    here.status = LocalizationStatus::kContradicted;
  } else if (here.inliers < options_.sure_inliers &&
             !(agreement.overlap >= options_.sure_overlap &&
               agreement.agreeing >= options_.sure_agreeing)) {
    here.status = LocalizationStatus::kDoubtful;
  } else {
    here.status = is_precise(here) ? LocalizationStatus::kFound : LocalizationStatus::kVague;
  }
  return here;
}

// Aligns the picture as a whole with the key-frame around it that shows most of the same.
void Localizer::refine(const Query& query, Localization& found) const {
  std::shared_ptr<const MeasuredKeyframe> best;
  PlacedKeyframe where;
  double most = 0;
  for (const std::size_t i : nearest(query, found.world_from_camera)) {
    const auto candidate = measured(i);
    if (!candidate) continue;
    const motion::ViewAgreement agreement = motion::compare_views(
        candidate->measurements.view(), query.measurements.view(),
        keyframes_[i].world_from_keyframe.inverse() * found.world_from_camera);
    const double shared = agreement.overlap * agreement.agreeing;
    if (shared <= most) continue;
    most = shared;
    best = candidate;
    where = keyframes_[i];
  }
  if (best) {
    const motion::PosePrior prior{where.world_from_keyframe.inverse() * found.world_from_camera,
                                  found.information};
    const motion::ViewAlignment aligned = motion::align_views(
        best->measurements.view(), query.measurements.view(), prior, options_.views);
    if (aligned.found) {
      found.keyframe = where.id;
      found.world_from_camera = where.world_from_keyframe * aligned.pose.reference_from_current;
      found.information = with_systematic_error(aligned.pose.information);
    }
  }
  found.agreement = agreement_around(query, found.world_from_camera);
}

Localization Localizer::likeliest(const std::vector<Localization>& answers) const {
  const auto has_hypothesis = [](const Localization& answer) {
    return answer.status > LocalizationStatus::kNoMotion;
  };
  Localization best = *std::ranges::max_element(answers, {}, [&](const Localization& answer) {
    return std::pair(has_hypothesis(answer), answer.inliers);
  });
  if (!has_hypothesis(best)) return best;
  for (const Localization& other : answers) {
    if (has_hypothesis(other) && !is_same(other.world_from_camera, best.world_from_camera))
      best.rival_inliers = std::max(best.rival_inliers, other.inliers);
  }
  if (best.inliers < options_.clearly_more_inliers * best.rival_inliers) {
    // Perceptual aliasing, as of twin rooms: nothing but more inliers tells them apart.
    if (best.status > LocalizationStatus::kDoubtful) best.status = LocalizationStatus::kAmbiguous;
  } else if (options_.color_only.probability(best.evidence()) >=
             options_.color_only.min_probability) {
    best.status = is_precise(best) ? LocalizationStatus::kFound : LocalizationStatus::kVague;
  } else if (best.status > LocalizationStatus::kDoubtful) {
    best.status = LocalizationStatus::kDoubtful;
  }
  return best;
}

// The best of what the similar places say.
Localization Localizer::by_features(const Query& query) const {
  std::vector<Localization> answers;
  for (const Place& place : similar_places(query)) {
    answers.push_back(locate_in(place, query));
  }
  if (answers.empty()) return {};
  if (!shows_depth(query)) return likeliest(answers);
  std::ranges::stable_sort(answers, [](const Localization& a, const Localization& b) {
    return std::pair(a.status, a.inliers) > std::pair(b.status, b.inliers);
  });
  Localization best = answers.front();
  for (const Localization& other : answers) {
    // Perceptual aliasing, as of twin rooms: nothing but more inliers tells them apart.
    if (best.found() && other.has_pose() &&
        !is_same(other.world_from_camera, best.world_from_camera) &&
        best.inliers < options_.clearly_more_inliers * other.inliers) {
      best.status = LocalizationStatus::kAmbiguous;
    }
  }
  if (best.status == LocalizationStatus::kDoubtful ||
      best.status == LocalizationStatus::kUnconfirmed ||
      best.status == LocalizationStatus::kContradicted) {
    return confirmed(query, answers).value_or(best);
  }
  return best;
}

std::optional<Localization> Localizer::confirmed(const Query& query,
                                                 const std::vector<Localization>& answers) const {
  const auto pattern = motion::ViewPattern::of(query.measurements.view());
  std::vector<Localization> poses;
  for (Localization pose : answers) {
    if (pose.status != LocalizationStatus::kDoubtful &&
        pose.status != LocalizationStatus::kUnconfirmed) {
      continue;
    }
    if (pose.agreement.overlap < options_.confirmed_overlap ||
        pose.agreement.seen_through > options_.max_confirmed_through) {
      continue;
    }
    pose.pattern_correlation = pattern_correlation_around(query, pattern, pose.world_from_camera);
    if (confirmation_score(pose) >= options_.min_confirmation) poses.push_back(pose);
  }
  if (poses.empty()) return std::nullopt;
  Localization best = *std::ranges::max_element(poses, {}, confirmation_score);
  const auto is_elsewhere = [&](const Localization& other) {
    return !is_same(other.world_from_camera, best.world_from_camera);
  };
  const bool has_rival = std::ranges::any_of(poses, is_elsewhere) ||
                         std::ranges::any_of(answers, [&](const Localization& other) {
                           return other.status >= LocalizationStatus::kContradicted &&
                                  is_elsewhere(other) &&
                                  other.inliers >= options_.clearly_more_inliers * best.inliers;
                         });
  if (has_rival || !is_precise(best)) return std::nullopt;
  best.status = LocalizationStatus::kFound;
  best.is_weak_hypothesis = true;
  return best;
}

// The different poses to which alignments with the key-frames lead whose depth images look most
// like the picture's.
std::vector<Localization> Localizer::align_shapes(const Query& query) const {
  struct Aligned {
    Localization pose;
    double rms = 0;
  };
  std::vector<Aligned> found;
  const motion::RgbdPyramid& view = query.measurements.view();
  for (const DepthIndex::Hit& hit :
       index_.depths().find(view, options_.similar_shapes, query.left_out)) {
    const PlacedKeyframe& keyframe = keyframes_[hit.index];
    const auto known_view = measured(hit.index);
    if (!known_view) continue;
    const auto prior = motion::PosePrior::around(hit.indexed_from_query, options_.shape_sigma_m,
                                                 options_.shape_sigma_rad);
    const motion::ViewAlignment aligned =
        motion::align_views(known_view->measurements.view(), view, prior, options_.shape_views);
    if (!aligned.found) continue;
    const RigidTransform pose = keyframe.world_from_keyframe * aligned.pose.reference_from_current;
    auto known = std::ranges::find_if(
        found, [&](const Aligned& one) { return is_same(one.pose.world_from_camera, pose); });
    if (known == found.end()) {
      known = found.insert(found.end(), Aligned{{}, std::numeric_limits<double>::infinity()});
    }
    ++known->pose.supporting_keyframes;
    if (aligned.pose.rms >= known->rms) continue;
    known->rms = aligned.pose.rms;
    known->pose.keyframe = keyframe.id;
    known->pose.world_from_camera = pose;
    known->pose.information = with_systematic_error(aligned.measured_information);
  }
  const auto pattern = motion::ViewPattern::of(view);
  std::vector<Localization> poses;
  for (Aligned& one : found) {
    one.pose.agreement = agreement_around(query, one.pose.world_from_camera);
    one.pose.pattern_correlation =
        pattern_correlation_around(query, pattern, one.pose.world_from_camera);
    one.pose.support = support(one.pose, one.rms);
    poses.push_back(one.pose);
  }
  return poses;
}

Localization Localizer::locate_by_depth(const Query& query) const {
  std::vector<Localization> poses = align_shapes(query);
  if (poses.empty()) return {};
  std::ranges::stable_sort(poses, std::ranges::greater(), &Localization::support);
  Localization best = poses.front();
  const bool may_have_slid =
      best.pattern_correlation < options_.sure_pattern_correlation &&
      min_normal_eigenvalue(query.measurements.view()) < options_.min_normal_eigenvalue;
  if (may_have_slid) {
    best.status = LocalizationStatus::kDegenerate;
  } else if (best.support < options_.sure_support) {
    best.status = LocalizationStatus::kDoubtful;
  } else if (poses.size() > 1 && poses[1].support > options_.max_rival_share * best.support) {
    best.status = LocalizationStatus::kAmbiguous;
  } else {
    best.status = is_precise(best) ? LocalizationStatus::kFound : LocalizationStatus::kVague;
  }
  return best;
}

// The second picture's place by the first one's and the motion between them, with the uncertainty
// of both.
Localization Localizer::propagate(const Localization& earlier, const motion::RefinedPose& motion,
                                  const Query& second) const {
  Localization carried = earlier;
  carried.is_carried = true;
  carried.world_from_camera = earlier.world_from_camera * motion.reference_from_current;
  // An error of the first camera's pose, as a twist (omega, v), is this one of the second's.
  const RigidTransform second_from_first = motion.reference_from_current.inverse();
  const Eigen::Matrix3d rotation = second_from_first.rotation_matrix();
  geometry::Matrix6d adjoint = geometry::Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = adjoint.bottomRightCorner<3, 3>() = rotation;
  for (int axis = 0; axis < 3; ++axis) {
    adjoint.block<3, 1>(3, axis) = second_from_first.translation.cross(rotation.col(axis));
  }
  const geometry::Matrix6d first = motion::twist_information(earlier.information).inverse();
  const geometry::Matrix6d between =
      motion::twist_information(with_systematic_error(motion.information)).inverse();
  carried.information =
      motion::edge_information((adjoint * first * adjoint.transpose() + between).inverse());
  if (shows_depth(second)) {
    carried.agreement = agreement_around(second, carried.world_from_camera);
  }
  if (is_contradicted(carried.agreement)) {
    carried.status = LocalizationStatus::kContradicted;
  } else if (carried.found() && !is_precise(carried)) {
    carried.status = LocalizationStatus::kVague;
  }
  return carried;
}

Localization Localizer::locate(const Query& query) const {
  const Localization answer = by_features(query);
  if ((answer.found() && !answer.is_weak_hypothesis) || !can_compare_shapes(query)) return answer;
  Localization shape = locate_by_depth(query);
  shape.matches = answer.matches;
  shape.inliers = answer.inliers;
  if (answer.is_weak_hypothesis) {
    if (!shape.found()) return answer;
    if (!is_same(shape.world_from_camera, answer.world_from_camera))
      shape.status = LocalizationStatus::kAmbiguous;
    return shape;
  }
  return shape.status > answer.status ? shape : answer;
}

PairLocalization Localizer::locate(const Query& first, const Query& second) const {
  PairLocalization places{locate(first), locate(second)};
  if (const auto carried = locate_by_motion(first, places.first, second))
    reconcile(*carried, places);
  return places;
}

Localizer::Followed Localizer::follow(const Query& earlier, const Localization& place,
                                      const Query& query) const {
  PairLocalization places{place, locate(query)};
  const bool is_near = places.second.found() &&
                       may_show_the_same(place.world_from_camera, places.second.world_from_camera);
  const Localization alone = places.second;
  if (is_near) return {alone, alone, std::nullopt};
  auto carried = locate_by_motion(earlier, place, query);
  const bool is_wrong = carried && carried->status == LocalizationStatus::kContradicted;
  if (carried && !(is_wrong && alone.found())) reconcile(*carried, places);
  return {places.second, alone, std::move(carried)};
}

bool Localizer::agree(const Query& first, const Localization& first_place, const Query& second,
                      const Localization& second_place) const {
  const auto carried = locate_by_motion(first, first_place, second);
  return carried && is_same(carried->world_from_camera, second_place.world_from_camera);
}

std::optional<Localization> Localizer::locate_by_motion(const Query& first,
                                                        const Localization& place,
                                                        const Query& second) const {
  if (!place.has_pose()) return std::nullopt;
  motion::LocatorOptions options;
  options.features = options_.features;
  const motion::MotionOutcome motion =
      motion::locate_frame(first.measurements, second.measurements, std::nullopt, second.camera,
                           options, RandomStream(options_.seed, {~0ULL}));
  if (!motion.found()) return std::nullopt;
  return propagate(place, motion.pose, second);
}

void Localizer::reconcile(const Localization& carried, PairLocalization& places) const {
  const Localization& earlier = places.first;
  Localization& later = places.second;
  if (later.has_pose() && is_same(carried.world_from_camera, later.world_from_camera)) {
    // Where a picture alone leaves two places open, the motion fits both.
    const bool one_is_open = earlier.status == LocalizationStatus::kAmbiguous ||
                             later.status == LocalizationStatus::kAmbiguous;
    if ((earlier.found() || !one_is_open) && is_precise(later)) {
      later.status = LocalizationStatus::kFound;
    }
    if (earlier.found())
      later.is_weak_hypothesis = later.is_weak_hypothesis && earlier.is_weak_hypothesis;
    return;
  }
  if (!earlier.found()) return;
  if (earlier.is_weak_hypothesis && later.found() && !later.is_weak_hypothesis)
    return;  // the surer one stands
  if (later.found()) {
    later.status = LocalizationStatus::kAmbiguous;
    places.contradictory = true;
  } else {
    later = carried;
    places.contradictory = carried.status == LocalizationStatus::kContradicted;
  }
}

}  // namespace roomwise::mapping
