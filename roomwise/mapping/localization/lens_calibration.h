#pragma once

#include <utility>
#include <vector>

#include "roomwise/mapping/localization/localization.h"

namespace roomwise::mapping {

// What the pictures of one device told of its lens, each a Query with estimate() that was answered:
// a calibration without a pattern, by the map. Pictures of one view share the map's errors, so a
// view counts once. Not thread-safe: what is asked by an estimate must be answered before the next.
class LensCalibration {
 public:
  LensCalibration() : LensCalibration(motion::IntrinsicsEstimate::typical_of_phones()) {}
  // Also goes on where another left off, which counted these views.
  explicit LensCalibration(const motion::IntrinsicsEstimate& known,
                           std::vector<geometry::RigidTransform> counted = {})
      : known_(known), counted_(std::move(counted)) {}

  // To be asked with next. Every tenth of pictures in a row without a pose as if nothing were
  // known: the device may have another lens now.
  [[nodiscard]] motion::IntrinsicsEstimate estimate() const;
  // What is known by now, to be kept.
  [[nodiscard]] const motion::IntrinsicsEstimate& known() const { return known_; }
  // world_from_camera of the views that it was learned from, the latest last: some 200 at most.
  [[nodiscard]] const std::vector<geometry::RigidTransform>& counted() const { return counted_; }
  // Whether the answer told something.
  bool add(const Localization& answer);

 private:
  [[nodiscard]] bool is_asked_anew() const;
  [[nodiscard]] bool counts(const geometry::RigidTransform& world_from_camera) const;

  motion::IntrinsicsEstimate known_;
  std::vector<geometry::RigidTransform> counted_;
  int without_pose_ = 0;  // pictures, in a row
};

}  // namespace roomwise::mapping
