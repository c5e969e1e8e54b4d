#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/frame_surface.h"
#include "roomwise/fusion/tsdf_volume.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

using FrameId = std::uint64_t;
using FramePoses = std::map<FrameId, geometry::RigidTransform>;  // field_from_camera

struct MapFusionOptions {
  TsdfOptions field;
  // A frame whose pose moved less stays where it was fused: a quarter of a voxel, and what the same
  // turn does 2 m away.
  double max_shift_m = 0.005;
  double max_turn_rad = 0.0025;

  [[nodiscard]] Expected<void> validate() const;
};

// A frame to take out of the field where it is, to put in where it belongs, or both.
struct Reintegration {
  FrameId frame = 0;
  std::optional<geometry::RigidTransform> out, in;  // field_from_camera
};

// A distance field that follows the poses of its frames: when they are corrected, those that moved
// are taken out at the old pose and put in at the new one (Dai et al., "BundleFusion: Real-time
// Globally Consistent 3D Reconstruction using On-the-fly Surface Re-integration", 2017). Since
// fusion is exact, the field is then the same, to the bit, as if all frames had been fused at those
// poses from the start. Frames are not kept: reintegrations_for() says which are needed, one after
// the other.
class MapFusion {
 public:
  // The options must be valid.
  explicit MapFusion(const MapFusionOptions& options, WorkingSet working_set = {})
      : options_(options), field_(options.field, std::move(working_set)) {}

  // What leads from the poses that are fused to `poses`, by frame. Frames that are missing there
  // are taken out.
  [[nodiscard]] std::vector<Reintegration> reintegrations_for(const FramePoses& poses) const;
  // Carries out one of reintegrations_for(); `frame` must be the same each time. Fails, changing
  // nothing, where the pose is not finite or the field holds all the frames that it can; and where
  // the field's scratch file does, then the frame may have been taken out.
  [[nodiscard]] Expected<void> apply(const Reintegration& step, const FrameSurface& frame,
                                     ThreadPool& pool);

  [[nodiscard]] const TsdfVolume& field() const { return field_; }
  [[nodiscard]] TsdfVolume& field() { return field_; }  // to bring its blocks into memory
  [[nodiscard]] const FramePoses& fused() const { return fused_; }

 private:
  MapFusionOptions options_;
  TsdfVolume field_;
  FramePoses fused_;
};

}  // namespace roomwise::fusion
