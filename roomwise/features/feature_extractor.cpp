#include "roomwise/features/feature_extractor.h"

#include <stdexcept>

#include "roomwise/features/opencv_extractors.h"
#include "roomwise/features/surf.h"

namespace roomwise::features {

Expected<FeatureKind> parse_feature_kind(std::string_view name) {
  for (const FeatureKind kind : {FeatureKind::kSurf, FeatureKind::kSift, FeatureKind::kOrb}) {
    if (name == to_string(kind)) return kind;
  }
  return fail("'{}' is no kind of feature; give surf, sift or orb", name);
}

std::string_view to_string(FeatureKind kind) {
  switch (kind) {
    case FeatureKind::kSurf:
      return "surf";
    case FeatureKind::kSift:
      return "sift";
    case FeatureKind::kOrb:
      return "orb";
  }
  throw std::invalid_argument("no such FeatureKind");
}

std::unique_ptr<FeatureExtractor> make_extractor(FeatureKind kind, int max_keypoints) {
  switch (kind) {
    case FeatureKind::kSurf: {
      SurfOptions options;
      options.max_keypoints = max_keypoints;
      return std::make_unique<SurfExtractor>(options);
    }
    case FeatureKind::kSift:
      return std::make_unique<SiftExtractor>(max_keypoints);
    case FeatureKind::kOrb:
      return std::make_unique<OrbExtractor>(max_keypoints);
  }
  throw std::invalid_argument("no such FeatureKind");
}

}  // namespace roomwise::features
