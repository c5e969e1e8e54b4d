#pragma once

#include <optional>
#include <span>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/rooms/recognition/localization_evidence.h"
#include "roomwise/rooms/recognition/room_classifier.h"
#include "roomwise/rooms/recognition/room_decision.h"
#include "roomwise/rooms/recognition/room_stream.h"
#include "roomwise/rooms/recognition/two_frame_rule.h"

namespace roomwise::pipeline {

// Says the room that pictures show: what a home learned, and the networks that it learned with. In
// two ways: by comparing them with the pictures that were learned from, and by their place on the
// map where that can be asked, which may end in "either", "not sure" and "none of them"; and by the
// paper's rule of two frames, which always names a room.
class RoomRecognizer {
 public:
  // `networks` must hold the one that the home's rooms were learned with (known by its fingerprint)
  // and outlive the recognizer; one that names things is used for representative objects, if there
  // is any: of several the one that looked at most of the home's pictures, since what it says of
  // the rooms' pictures is known.
  [[nodiscard]] static Expected<RoomRecognizer> create(const home::Home& home,
                                                       const Networks& networks);

  // What naming() sees in a picture; asked only where it is needed. Empty: no objects are looked
  // for.
  using PredictLabels = std::function<Expected<network::Prediction>()>;

  // What the place of the pictures tells (HomePlaces); asked only where it may change the answer.
  // Empty: no place is looked for.
  using Localize = std::function<Expected<rooms::LocalizationEvidence>()>;

  // ---- by comparing ----
  // For what features() saw in a picture.
  [[nodiscard]] Expected<rooms::PictureEvidence> evidence(const network::Prediction& seen) const {
    return classifier_.evidence(seen.features);
  }
  // From pictures of one place. Objects of the last one are looked for only where the pictures are
  // known but, with their place, do not tell the room.
  [[nodiscard]] Expected<rooms::RoomDecision> decide(
      std::span<const rooms::PictureEvidence> pictures, const PredictLabels& predict_labels,
      const Localize& localize = {}) const;
  // From the pictures themselves, one or more of one place.
  [[nodiscard]] Expected<rooms::RoomDecision> recognize(std::span<const image::ColorImage> pictures,
                                                        const Localize& localize = {}) const;
  // For pictures of a walk, one after the other.
  [[nodiscard]] rooms::RoomStream stream() const { return {topology_, model()}; }
  // The next picture of a walk, `elapsed_s` after the one before, by what features() saw in it.
  [[nodiscard]] Expected<rooms::RoomDecision> update(rooms::RoomStream& stream,
                                                     const rooms::PictureEvidence& picture,
                                                     double elapsed_s,
                                                     const Localize& localize = {}) const;

  // ---- the paper's way ----
  // Every room with its probability, best first.
  [[nodiscard]] Expected<std::vector<rooms::RoomScore>> paper_scores(
      const network::Prediction& seen) const {
    return classifier_.scores(seen.features);
  }
  // The rule of two frames; predict_labels is asked only when the pictures differ.
  [[nodiscard]] Expected<rooms::RoomAnswer> paper_decide(const rooms::RoomScore& first,
                                                         const rooms::RoomScore& second,
                                                         const PredictLabels& predict_labels) const;
  // From pictures; without a second one the first alone decides.
  [[nodiscard]] Expected<rooms::RoomAnswer> paper_recognize(
      const image::ColorImage& first, const std::optional<image::ColorImage>& second) const;

  // As it was learned, with what later visits brought.
  [[nodiscard]] const rooms::RoomClassifier& classifier() const { return classifier_; }
  [[nodiscard]] const network::Classifier& features() const { return *features_; }
  [[nodiscard]] const network::Classifier* naming() const { return naming_; }  // nullptr: none
  [[nodiscard]] const std::vector<std::string>& rooms() const { return classifier_.rooms(); }
  [[nodiscard]] const rooms::RoomCalibration& calibration() const {
    return classifier_.retrieval().calibration;
  }
  [[nodiscard]] const rooms::RoomModel& model() const { return classifier_.model(); }
  // Which rooms doors lead between, by the walks whose rooms were named.
  [[nodiscard]] const rooms::RoomTopology& topology() const { return topology_; }

 private:
  RoomRecognizer(rooms::RoomClassifier classifier, rooms::Concepts concepts,
                 std::vector<rooms::Room> rooms, rooms::RoomObjects room_objects,
                 rooms::RoomTopology topology, const network::Classifier* features,
                 const network::Classifier* naming)
      : classifier_(std::move(classifier)),
        concepts_(std::move(concepts)),
        rooms_(std::move(rooms)),
        room_objects_(std::move(room_objects)),
        topology_(std::move(topology)),
        features_(features),
        naming_(naming) {}
  [[nodiscard]] Expected<std::vector<objects::ObjectScore>> objects_in(
      const PredictLabels& names) const;
  [[nodiscard]] Expected<std::optional<rooms::LocalizationEvidence>> localize_if_needed(
      const rooms::PictureEvidence& pictures, const Localize& localize) const;

  rooms::RoomClassifier classifier_;
  rooms::Concepts concepts_;
  std::vector<rooms::Room> rooms_;  // those that were learned, in their order
  rooms::RoomObjects room_objects_;
  rooms::RoomTopology topology_;
  const network::Classifier* features_;
  const network::Classifier* naming_;
};

}  // namespace roomwise::pipeline
