#pragma once

#include <span>
#include <utility>
#include <vector>

#include "roomwise/fusion/map_fusion.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// A map as a distance field in its world frame, which can follow when the map is corrected.
class DenseMap {
 public:
  // The options must be valid.
  explicit DenseMap(const fusion::MapFusionOptions& options, WorkingSet working_set = {},
                    const fusion::SurfaceOptions& surface = {})
      : fusion_(options, std::move(working_set)), surface_(surface) {}

  // Fuses these key-frames at the poses given with them. Those that are fused already follow where
  // their poses moved, and those that are not among them are taken out; the home must still have
  // their images. What had been fused when it fails stays in good order.
  [[nodiscard]] Expected<void> follow(const home::Home& home,
                                      std::span<const home::Keyframe> keyframes, RunContext& run);

  [[nodiscard]] const fusion::TsdfVolume& field() const { return fusion_.field(); }
  [[nodiscard]] fusion::TsdfVolume& field() { return fusion_.field(); }
  [[nodiscard]] const fusion::FramePoses& fused() const { return fusion_.fused(); }

 private:
  fusion::MapFusion fusion_;
  fusion::SurfaceOptions surface_;
};

// What of a home's dense map stays in memory: voxels, and as much of its surface. The rest waits in
// a scratch file beside the home or, where its folder cannot be written, in the folder for
// temporary files.
[[nodiscard]] WorkingSet dense_working_set(const home::Home& home, const RunContext& run);

// These key-frames, fused at the poses given with them, with that working set.
[[nodiscard]] Expected<DenseMap> build_dense_map(const home::Home& home,
                                                 std::span<const home::Keyframe> keyframes,
                                                 const fusion::TsdfOptions& field, RunContext& run);

}  // namespace roomwise::pipeline
