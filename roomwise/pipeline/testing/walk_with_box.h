#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline::testing {

// A box that stands before the camera in a walk: drawn into pictures and depth.
struct DrawnBox {
  Eigen::AlignedBox3d extent;
  Rgb8 color{250, 0, 0};

  void draw(image::RgbdFrame& frame, const geometry::RigidTransform& world_from_camera,
            const geometry::PinholeCamera& camera) const {
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Array3d along =
            (world_from_camera.rotation * camera.unproject(Eigen::Vector2d(x, y), 1)).array() +
            1e-9;
        const Eigen::Array3d low = (extent.min() - world_from_camera.translation).array() / along;
        const Eigen::Array3d high = (extent.max() - world_from_camera.translation).array() / along;
        const double z_m = low.min(high).maxCoeff();
        if (z_m <= 0 || z_m > low.max(high).minCoeff()) continue;
        frame.color.at(x, y) = color;
        frame.depth.at(x, y) = static_cast<std::uint16_t>(std::lround(1000 * z_m));
      }
    }
  }
};

// A walk through the made-up home with a red box in it, or none.
class WalkWithBox final : public recording::FrameSource {
 public:
  WalkWithBox(int frames, double step_rad, std::optional<DrawnBox> box)
      : walk_(frames, step_rad), box_(box) {}
  void begin_at(TimestampNs begins_ns) { walk_.begins_ns = begins_ns; }
  [[nodiscard]] const recording::SourceInfo& info() const override { return walk_.info(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    ROOMWISE_TRY(auto frame, walk_.next());
    if (frame && box_) {
      box_->draw(*frame, walk_.world_from_camera(static_cast<int>(frame->index)), info().camera);
    }
    return frame;
  }

 private:
  SyntheticWalk walk_;
  std::optional<DrawnBox> box_;
};

}  // namespace roomwise::pipeline::testing
