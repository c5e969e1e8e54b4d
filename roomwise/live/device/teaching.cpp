#include "roomwise/live/device/teaching.h"

namespace roomwise::live {

Teaching::Reply Teaching::take(const FrameImages& images, double depth_units_per_metre,
                               double t_ms) {
  // So long a fault is being spoken and mended.
  constexpr double kBetweenFaults_ms = 3000;
  constexpr double kStopsAfter_ms = 60'000;
  if (has_enough()) return {};
  if (!went_on_t_ms_) went_on_t_ms_ = t_ms;
  if (t_ms - *went_on_t_ms_ > kStopsAfter_ms) return {guide::TeachingStep::kStopped, std::nullopt};
  std::optional<objects::ShownDepth> depth;
  if (images.depth) depth.emplace(objects::ShownDepth{*images.depth, depth_units_per_metre});
  auto found = objects::find_shown(images.color, depth);
  if (!found) {
    const bool was_said = last_fault_t_ms_ && t_ms - *last_fault_t_ms_ < kBetweenFaults_ms;
    if (was_said) return {};
    last_fault_t_ms_ = t_ms;
    return {std::nullopt, found.error()};
  }
  shown_.push_back(*std::move(found));
  went_on_t_ms_ = t_ms;
  has_enough_ = shown_.size() >= kEnough;
  if (has_enough()) return {guide::TeachingStep::kEnough, std::nullopt};
  if (shown_.size() == kEnough / 2) return {guide::TeachingStep::kGoOn, std::nullopt};
  return {};
}

}  // namespace roomwise::live
