#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "roomwise/motion/measured_features.h"
#include "roomwise/motion/rgbd_pyramid.h"

namespace roomwise::motion {

// What mapping takes from an RGB-D frame. Features are found when they are first asked for, since
// most frames of a walk are located without them; not to be asked from two threads at once. A copy
// made before finds its own.
class FrameMeasurements {
 public:
  // Without a view (the paper's method needs none), or with one.
  FrameMeasurements(MeasuredFeatures features, RgbdPyramid view = {})  // NOLINT: may convert
      : view_(std::move(view)), features_(std::move(features)) {}
  FrameMeasurements(RgbdPyramid view, std::function<MeasuredFeatures()> measure)
      : view_(std::move(view)), measure_(std::move(measure)) {}

  [[nodiscard]] const RgbdPyramid& view() const { return view_; }
  [[nodiscard]] const MeasuredFeatures& features() const {
    if (!features_) {
      features_ = measure_();
      measure_ = nullptr;  // lets go of the image
    }
    return *features_;
  }

 private:
  RgbdPyramid view_;
  mutable std::function<MeasuredFeatures()> measure_;
  mutable std::optional<MeasuredFeatures> features_;
};

}  // namespace roomwise::motion
