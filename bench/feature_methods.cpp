#include "feature_methods.h"

#include "roomwise/features/opencv_extractors.h"
#include "roomwise/features/surf.h"
#if defined(ROOMWISE_HAS_DLIB)
#include "dlib_surf.h"
#endif

namespace roomwise::bench {

std::vector<FeatureMethod> feature_methods(int max_keypoints) {
  std::vector<FeatureMethod> methods;
  const features::SurfOptions options{.hessian_threshold = 0.1, .max_keypoints = max_keypoints};
  methods.push_back({"surf", std::make_unique<features::SurfExtractor>(options)});
  methods.push_back(
      {"surf-portable", std::make_unique<features::SurfExtractor>(options, Simd::kPortable)});
#if defined(ROOMWISE_HAS_DLIB)
  methods.push_back({"dlib-surf", std::make_unique<DlibSurfExtractor>(max_keypoints)});
#endif
  methods.push_back({"sift", std::make_unique<features::SiftExtractor>(max_keypoints, 0.005)});
  methods.push_back({"orb", std::make_unique<features::OrbExtractor>(max_keypoints, 5)});
  return methods;
}

}  // namespace roomwise::bench
