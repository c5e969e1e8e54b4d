#pragma once

#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/frame_surface.h"
#include "roomwise/fusion/tsdf_volume.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

// The sums of a field hold at least that many frames without overflow.
constexpr std::size_t kMaxFrames = 16'000;

// Adds what a frame tells to every voxel that it sees: the distance to the surface there, cut off
// at the truncation before it, down to two voxels (or three sigmas of the depth) behind it, and the
// colour near it. What the frame sees as empty is added too: a thing that was there and is gone, or
// was fused at a wrong place, is outvoted.
//
// What is added depends on the frame and the pose alone, not on the field. So frames may be fused
// in any order, and deintegrate_frame() with the same frame and pose leaves the field, to the bit,
// as if the frame had never been. The same bits at any number of threads. The pose must be finite.
// Errors are those of the field's scratch file; the field is then as it was.
[[nodiscard]] Expected<void> integrate_frame(TsdfVolume& field, const FrameSurface& frame,
                                             const geometry::RigidTransform& field_from_camera,
                                             ThreadPool& pool);
// Only for a frame that was added at that pose.
[[nodiscard]] Expected<void> deintegrate_frame(TsdfVolume& field, const FrameSurface& frame,
                                               const geometry::RigidTransform& field_from_camera,
                                               ThreadPool& pool);

}  // namespace roomwise::fusion
