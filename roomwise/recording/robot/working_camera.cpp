#include "roomwise/recording/robot/working_camera.h"

#include "roomwise/recording/phone/one_camera.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;

constexpr int kMaxWorkingSide_px = 640;

bool has_size_of(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height;
}

}  // namespace

Expected<WorkingCamera> working_camera(const PinholeCamera& recorded,
                                       const std::optional<PinholeCamera>& given) {
  WorkingCamera camera{recorded, common_camera(std::span(&recorded, 1), kMaxWorkingSide_px)};
  if (!given) return camera;
  PinholeCamera other = *given;
  other.depth_units_per_metre = recorded.depth_units_per_metre;
  if (has_size_of(other, recorded)) {
    camera.recorded = other;
    camera.working = common_camera(std::span(&other, 1), kMaxWorkingSide_px);
    return camera;
  }
  if (has_size_of(other, camera.working)) {
    camera.recorded = in_size(other, recorded.width, recorded.height);
    camera.working = other;
    return camera;
  }
  return fail("the pictures have {}x{} pixels, the camera that is given {}x{}", recorded.width,
              recorded.height, other.width, other.height);
}

}  // namespace roomwise::recording
