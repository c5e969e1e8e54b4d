#include "roomwise/pipeline/rooms/turn_hint.h"

#include "roomwise/features/feature_extractor.h"
#include "roomwise/image/resample.h"

namespace roomwise::pipeline {
namespace {

constexpr int kMaxCorners = 500;
constexpr int kFewFeatures = 30;
constexpr int kTimesAsMany = 3;

}  // namespace

std::optional<Side> side_with_more_to_see(const image::ColorImage& picture) {
  const auto extractor = features::make_extractor(features::FeatureKind::kOrb, kMaxCorners);
  const features::Features found = extractor->extract(image::to_gray(picture));
  const float middle = static_cast<float>(picture.width() - 1) / 2;
  int left = 0;
  int right = 0;
  for (const features::Keypoint& keypoint : found.keypoints) {
    ++(keypoint.position_px.x() < middle ? left : right);
  }
  if (left >= kFewFeatures && left >= kTimesAsMany * right) return Side::kLeft;
  if (right >= kFewFeatures && right >= kTimesAsMany * left) return Side::kRight;
  return std::nullopt;
}

std::string turn_hint(const image::ColorImage& picture) {
  const auto side = side_with_more_to_see(picture);
  if (!side) return "turn slowly and take another picture";
  return std::string("turn a little to the ") + (*side == Side::kLeft ? "left" : "right") +
         ": there is more to see on that side";
}

}  // namespace roomwise::pipeline
