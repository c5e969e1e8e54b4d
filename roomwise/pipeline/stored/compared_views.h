#pragma once

#include <map>

#include "roomwise/home/home.h"
#include "roomwise/motion/view_agreement.h"

namespace roomwise::pipeline {

// What key-frames of a home measured, as small as views are compared (motion::compare_views). Each
// is read when it is first asked for, and kept: some 14 kB. The home must outlive it.
class ComparedViews {
 public:
  [[nodiscard]] static Expected<ComparedViews> of(const home::Home& home);

  // How well the depths of two agree at a pose. Fails where a depth image is damaged, naming the
  // key-frame.
  [[nodiscard]] Expected<motion::ViewAgreement> compare(
      home::KeyframeId reference, home::KeyframeId current,
      const geometry::RigidTransform& reference_from_current);

 private:
  explicit ComparedViews(const home::Home& home) : home_(&home) {}
  [[nodiscard]] Expected<const motion::RgbdPyramid*> view(home::KeyframeId id);

  const home::Home* home_;
  std::map<home::KeyframeId, geometry::PinholeCamera> cameras_;
  std::map<home::KeyframeId, motion::RgbdPyramid> views_;
};

}  // namespace roomwise::pipeline
