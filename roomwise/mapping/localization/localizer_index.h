#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/mapping/frontend/appearance_index.h"
#include "roomwise/mapping/localization/depth_index.h"
#include "roomwise/motion/frame_measurements.h"
#include "roomwise/motion/view_pattern.h"

namespace roomwise::mapping {

// A key-frame as a picture is compared with it.
struct MeasuredKeyframe {
  motion::FrameMeasurements measurements;  // its features were found
  motion::ViewPattern pattern;

  [[nodiscard]] static MeasuredKeyframe of(motion::FrameMeasurements measurements);
};

// Which key-frames of a map look like a picture, by features and by depth: some 14 kB each, where
// what was measured in one takes 400 kB. So it is kept, and with it a map answers at once, having
// measured none but the key-frames that a question asks for.
class LocalizerIndex {
 public:
  LocalizerIndex();

  // The features must be of one kind; all key-frames have views, of one camera, or none has.
  void add(const motion::FrameMeasurements& measurements);

  // Of some of its key-frames, by place, ascending.
  void keep_only(std::span<const std::size_t> kept);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const AppearanceIndex& appearances() const { return appearances_; }
  [[nodiscard]] const DepthIndex& depths() const { return depths_; }
  // Of the views' smallest level; nothing where there are none.
  [[nodiscard]] const std::optional<geometry::PinholeCamera>& view_camera() const {
    return view_camera_;
  }

  // For this program alone, which wrote them.
  [[nodiscard]] Bytes to_bytes() const;
  // Nothing where the bytes are not what to_bytes() gave.
  [[nodiscard]] static std::optional<LocalizerIndex> from_bytes(
      std::span<const std::uint8_t> bytes);

 private:
  std::size_t size_ = 0;
  AppearanceIndex appearances_;  // by place in the order of adding
  DepthIndex depths_;            // likewise
  std::optional<geometry::PinholeCamera> view_camera_;
};

}  // namespace roomwise::mapping
