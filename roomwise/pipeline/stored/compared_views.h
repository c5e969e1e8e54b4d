#pragma once

#include <map>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/motion/view_agreement.h"

namespace roomwise::pipeline {

// What key-frames of a home measured, as small as views are compared (motion::compare_views). Each
// is read when it is first asked for, and kept: some 14 kB. The home must outlive it.
class ComparedViews {
 public:
  [[nodiscard]] static Expected<ComparedViews> of(const home::Home& home);

  // How well the depths of two agree at a pose. One whose depth image cannot be read overlaps with
  // none: the others tell as much.
  [[nodiscard]] motion::ViewAgreement compare(
      home::KeyframeId reference, home::KeyframeId current,
      const geometry::RigidTransform& reference_from_current);
  // Why those could not be read that were asked for, one line each.
  [[nodiscard]] const std::map<home::KeyframeId, std::string>& unread() const { return unread_; }

 private:
  explicit ComparedViews(const home::Home& home) : home_(&home) {}
  [[nodiscard]] const motion::RgbdPyramid& view(home::KeyframeId id);
  [[nodiscard]] Expected<motion::RgbdPyramid> read(home::KeyframeId id) const;

  const home::Home* home_;
  std::map<home::KeyframeId, geometry::PinholeCamera> cameras_;
  std::map<home::KeyframeId, motion::RgbdPyramid> views_;  // empty: unread
  std::map<home::KeyframeId, std::string> unread_;
};

}  // namespace roomwise::pipeline
