#include "roomwise/fusion/map_fusion.h"

#include "roomwise/fusion/frame_fusion.h"

namespace roomwise::fusion {

Expected<void> MapFusionOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(field.validate());
  if (!(max_shift_m >= 0)) return fail("max_shift_m is {}; expected 0 or more", max_shift_m);
  if (!(max_turn_rad >= 0)) return fail("max_turn_rad is {}; expected 0 or more", max_turn_rad);
  return {};
}

std::vector<Reintegration> MapFusion::reintegrations_for(const FramePoses& poses) const {
  std::vector<Reintegration> steps;
  for (const auto& [frame, pose] : fused_) {
    if (!poses.contains(frame)) steps.push_back({frame, pose, std::nullopt});
  }
  for (const auto& [frame, pose] : poses) {
    const auto there = fused_.find(frame);
    if (there == fused_.end()) {
      steps.push_back({frame, std::nullopt, pose});
      continue;
    }
    const geometry::RigidTransform moved = there->second.inverse() * pose;
    const bool stays =
        moved.distance_m() <= options_.max_shift_m && moved.angle_rad() <= options_.max_turn_rad;
    if (!stays) steps.push_back({frame, there->second, pose});
  }
  return steps;
}

Expected<void> MapFusion::apply(const Reintegration& step, const FrameSurface& frame,
                                ThreadPool& pool) {
  if (step.in && !step.in->is_finite())
    return fail("the pose of frame {} is not finite", step.frame);
  if (step.in && !step.out && fused_.size() >= kMaxFrames) {
    return fail("a dense map holds at most {} key-frames", kMaxFrames);
  }
  if (step.out) {
    ROOMWISE_RETURN_IF_ERROR(deintegrate_frame(field_, frame, *step.out, pool));
    fused_.erase(step.frame);
  }
  if (step.in) {
    ROOMWISE_RETURN_IF_ERROR(integrate_frame(field_, frame, *step.in, pool));
    fused_[step.frame] = *step.in;
  }
  return {};
}

}  // namespace roomwise::fusion
