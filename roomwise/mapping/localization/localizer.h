#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/localization/localization.h"
#include "roomwise/mapping/localization/localizer_index.h"
#include "roomwise/motion/lens_motion.h"

namespace roomwise::mapping {

// A picture to be localised, and the camera that took it. Depth is welcome, and not needed. Of a
// camera that nobody calibrated `lens` is what is known: then `camera` says no more than how large
// the picture is, its measurements are as without distortion, and its depth does not count.
struct Query {
  const motion::FrameMeasurements& measurements;
  const geometry::PinholeCamera& camera;
  std::optional<motion::IntrinsicsEstimate> lens = std::nullopt;
  // By place among the map's key-frames: the answer is what a map without these would say. Empty:
  // without none.
  std::vector<bool> left_out = {};

  [[nodiscard]] bool leaves_out(std::size_t place) const {
    return place < left_out.size() && left_out[place];
  }
};

// A key-frame of a finished map, and where it is.
struct PlacedKeyframe {
  KeyframeId id = 0;
  geometry::RigidTransform world_from_keyframe;
};

// What was measured in a key-frame, by its place among a map's; may be asked for from several
// threads at once. Null where it cannot be had: then nothing is compared with the key-frame.
using MeasureKeyframe = std::function<std::shared_ptr<const MeasuredKeyframe>(std::size_t)>;

// Says where in a finished map a picture was taken, from nothing but the picture: on another day,
// after the light changed and things moved.
//
// First by features: the key-frames that look most like the picture (AppearanceIndex) and stand
// together are a place, whose points are matched with the picture together and give its pose by
// PnP in RANSAC; the picture is then aligned as a whole with a key-frame, and the depth images of
// those around must agree. A pose of a few inliers is a weak hypothesis, and believed where pattern
// and depth of the key-frames around confirm it. Where all that gives no sure answer, by shape, if
// the picture has depth and its camera is like the map's: the picture is aligned with the
// key-frames whose depth images look most like its own (DepthIndex); poses to which several lead,
// and that those around agree with in depth and in the pattern on their surfaces (ViewPattern), are
// believed, unless another has nearly as much support, as in front of a bare wall.
//
// It says no where too little speaks for a pose, since a wrong answer is worse than none. Same map,
// options and picture, same bits. May be asked from several threads at once.
class Localizer {
 public:
  // Options must be valid.
  explicit Localizer(const LocalizerOptions& options);
  // Of key-frames of one world that were indexed in their order, and are measured when they are
  // asked for.
  Localizer(const LocalizerOptions& options, LocalizerIndex index,
            std::vector<PlacedKeyframe> keyframes, MeasureKeyframe measure);

  // Key-frames of one world, held in memory. Their features must be of the queries' kind; all have
  // views, of one camera, or none has (and nothing is found by shape).
  void add(Keyframe keyframe, const geometry::RigidTransform& world_from_keyframe);
  [[nodiscard]] std::size_t size() const { return keyframes_.size(); }

  [[nodiscard]] Localization locate(const Query& query) const;
  // Of two pictures that were taken shortly after one another. What the second alone leaves in
  // doubt is an answer where both tell the same by the motion between them; where they contradict
  // each other it has none.
  [[nodiscard]] PairLocalization locate(const Query& first, const Query& second) const;
  // What a picture tells that was taken shortly after one whose place is known.
  struct Followed {
    // Where it alone gives no answer, the motion since then does, as long as that leaves the place
    // precise and what the map shows there does not contradict it. Where it alone tells a place to
    // which that motion does not lead, it has none, unless the map contradicts where it leads.
    Localization place;
    Localization alone;  // what it tells by itself
    // By the motion alone; nothing where that is not known, or was not asked for since the picture
    // alone tells of a place nearby.
    std::optional<Localization> carried;
  };
  [[nodiscard]] Followed follow(const Query& earlier, const Localization& place,
                                const Query& query) const;
  // Whether the motion between two pictures leads from the place of the one to that of the other.
  [[nodiscard]] bool agree(const Query& first, const Localization& first_place, const Query& second,
                           const Localization& second_place) const;

 private:
  // Key-frames that show one place, by their index; the first looks most like the picture.
  struct Place {
    std::vector<std::size_t> members;
    double votes = 0;
  };
  [[nodiscard]] bool may_show_the_same(const geometry::RigidTransform& a,
                                       const geometry::RigidTransform& b) const;
  [[nodiscard]] bool is_same(const geometry::RigidTransform& a,
                             const geometry::RigidTransform& b) const;
  [[nodiscard]] std::vector<std::size_t> nearest(const Query& query,
                                                 const geometry::RigidTransform& pose) const;
  [[nodiscard]] motion::ViewAgreement agreement_around(const Query& query,
                                                       const geometry::RigidTransform& pose) const;
  [[nodiscard]] double pattern_correlation_around(const Query& query,
                                                  const motion::ViewPattern& pattern,
                                                  const geometry::RigidTransform& pose) const;
  [[nodiscard]] bool is_contradicted(const motion::ViewAgreement& agreement) const;
  [[nodiscard]] bool is_precise(const Localization& found) const;
  [[nodiscard]] bool shows_depth(const Query& query) const;
  [[nodiscard]] bool can_compare_shapes(const Query& query) const;

  [[nodiscard]] std::vector<Place> similar_places(const Query& query) const;
  [[nodiscard]] std::vector<motion::PointObservation> match(const Place& place,
                                                            const Query& query) const;
  [[nodiscard]] motion::LensMotion pose_in(const Place& place,
                                           std::span<const motion::PointObservation> observations,
                                           const Query& query) const;
  [[nodiscard]] Localization locate_in(const Place& place, const Query& query) const;
  void refine(const Query& query, Localization& found) const;
  // The pose of too few inliers that pattern and depth around confirm best, if they do and nothing
  // speaks for another.
  [[nodiscard]] std::optional<Localization> confirmed(
      const Query& query, const std::vector<Localization>& answers) const;
  // Of answers without depth the one with most inliers, if it is probable enough.
  [[nodiscard]] Localization likeliest(const std::vector<Localization>& answers) const;
  [[nodiscard]] Localization by_features(const Query& query) const;

  [[nodiscard]] std::vector<Localization> align_shapes(const Query& query) const;
  [[nodiscard]] Localization locate_by_depth(const Query& query) const;
  // The second's place by the first's and the motion between them; nothing where they show too
  // little of the same.
  [[nodiscard]] std::optional<Localization> locate_by_motion(const Query& first,
                                                             const Localization& place,
                                                             const Query& second) const;
  // What each alone tells of the second, where the motion between them leads to `carried`.
  void reconcile(const Localization& carried, PairLocalization& places) const;
  [[nodiscard]] Localization propagate(const Localization& earlier,
                                       const motion::RefinedPose& motion,
                                       const Query& second) const;

  // What is known of a key-frame, by its index; may be null.
  [[nodiscard]] std::shared_ptr<const MeasuredKeyframe> measured(std::size_t index) const;

  LocalizerOptions options_;
  std::vector<PlacedKeyframe> keyframes_;
  LocalizerIndex index_;                                       // of keyframes_
  std::vector<std::shared_ptr<const MeasuredKeyframe>> held_;  // of those that were added
  MeasureKeyframe measure_;
};

}  // namespace roomwise::mapping
