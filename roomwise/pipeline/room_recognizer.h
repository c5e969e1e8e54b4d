#pragma once

#include <optional>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/keyframe_observer.h"
#include "roomwise/rooms/room_classifier.h"
#include "roomwise/rooms/two_frame_rule.h"

namespace roomwise::pipeline {

// Says the room that one or two pictures show: what a home learned, and the networks that it
// learned with.
class RoomRecognizer {
 public:
  // `networks` must hold the one that the home's rooms were learned with (known by its fingerprint)
  // and outlive the recognizer; one that names things is used for representative objects, if there
  // is any.
  [[nodiscard]] static Expected<RoomRecognizer> create(const home::Home& home,
                                                       const Networks& networks);

  // Every room with its probability, best first, for what features() saw in a picture.
  [[nodiscard]] Expected<std::vector<rooms::RoomScore>> scores(
      const network::Prediction& seen) const {
    return classifier_.scores(seen.features);
  }
  // The paper's rule. `named_second` is what naming() sees in the second picture; it is asked only
  // when the pictures differ.
  using SeeNames = std::function<Expected<network::Prediction>()>;
  [[nodiscard]] Expected<rooms::RoomAnswer> decide(const rooms::RoomScore& first,
                                                   const rooms::RoomScore& second,
                                                   const SeeNames& named_second) const;

  // From pictures; without a second one the first alone decides.
  [[nodiscard]] Expected<rooms::RoomAnswer> recognize(
      const image::ColorImage& first, const std::optional<image::ColorImage>& second) const;

  [[nodiscard]] const network::Classifier& features() const { return *features_; }
  [[nodiscard]] const network::Classifier* naming() const { return naming_; }  // nullptr: none
  [[nodiscard]] const std::vector<std::string>& rooms() const { return classifier_.rooms(); }

 private:
  RoomRecognizer(rooms::RoomClassifier classifier, rooms::Concepts concepts,
                 std::vector<rooms::Room> rooms, const network::Classifier* features,
                 const network::Classifier* naming)
      : classifier_(std::move(classifier)),
        concepts_(std::move(concepts)),
        rooms_(std::move(rooms)),
        features_(features),
        naming_(naming) {}

  rooms::RoomClassifier classifier_;
  rooms::Concepts concepts_;
  std::vector<rooms::Room> rooms_;  // those that were learned
  const network::Classifier* features_;
  const network::Classifier* naming_;
};

}  // namespace roomwise::pipeline
