#pragma once

#include <span>
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
  explicit DenseMap(const fusion::MapFusionOptions& options,
                    const fusion::SurfaceOptions& surface = {})
      : fusion_(options), surface_(surface) {}

  // Fuses these key-frames at the poses given with them. Those that are fused already follow where
  // their poses moved, and those that are not among them are taken out; the home must still have
  // their images. What had been fused when it fails stays in good order.
  [[nodiscard]] Expected<void> follow(const home::Home& home,
                                      std::span<const home::Keyframe> keyframes, RunContext& run);

  [[nodiscard]] const fusion::TsdfVolume& field() const { return fusion_.field(); }
  [[nodiscard]] const fusion::FramePoses& fused() const { return fusion_.fused(); }

 private:
  fusion::MapFusion fusion_;
  fusion::SurfaceOptions surface_;
};

// These key-frames, fused at the poses given with them.
[[nodiscard]] Expected<DenseMap> build_dense_map(const home::Home& home,
                                                 std::span<const home::Keyframe> keyframes,
                                                 const fusion::TsdfOptions& field, RunContext& run);

}  // namespace roomwise::pipeline
