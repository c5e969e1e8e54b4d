#include "roomwise/features/surf.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "roomwise/features/keypoint_selection.h"
#include "roomwise/features/surf_detector.h"
#include "roomwise/features/surf_pyramid.h"

namespace roomwise::features {

Expected<void> SurfOptions::validate() const {
  if (!(hessian_threshold >= 0 && std::isfinite(hessian_threshold))) {
    return fail("SURF's hessian_threshold is {}; it must be at least 0", hessian_threshold);
  }
  if (octaves < 1 || octaves > 6) return fail("SURF's octaves are {}; give 1 to 6", octaves);
  if (!(max_edge_ratio == 0 || (max_edge_ratio >= 1 && std::isfinite(max_edge_ratio)))) {
    return fail("SURF's max_edge_ratio is {}; give 0 (no limit), or 1 or more", max_edge_ratio);
  }
  if (max_keypoints < 0) {
    return fail("SURF's max_keypoints is {}; give 0 (all) or more", max_keypoints);
  }
  if (spread_cells < 0 || spread_cells > 100) {
    return fail("SURF's spread_cells is {}; give 0 (no grid) to 100", spread_cells);
  }
  return {};
}

namespace {

// From top to bottom, small ones first: what lies side by side is read from memory once.
void sort_by_place(const std::vector<Keypoint>& keypoints, std::vector<std::size_t>& order) {
  order.resize(keypoints.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    constexpr float kOctave = 64;  // px: about where the pyramid's second octave takes over
    return std::tuple(keypoints[i].size_px > kOctave, keypoints[i].position_px.y(), i);
  };
  std::ranges::sort(order, {}, key);
}

}  // namespace

struct SurfExtractor::Workspace {
  SurfPyramid pyramid;
  SurfDetector detector;
  std::vector<Blob> blobs;
  std::vector<Keypoint> keypoints;
  KeypointSelection selection;
  std::vector<std::size_t> order;
};

// A workspace that no other thread has meanwhile.
class SurfExtractor::Lease {
 public:
  explicit Lease(const SurfExtractor& extractor) : extractor_(extractor) {
    const std::lock_guard lock(extractor_.mutex_);
    if (!extractor_.idle_.empty()) {
      workspace_ = std::move(extractor_.idle_.back());
      extractor_.idle_.pop_back();
    } else {
      workspace_ = std::make_unique<Workspace>();
    }
  }
  ~Lease() {
    const std::lock_guard lock(extractor_.mutex_);
    extractor_.idle_.push_back(std::move(workspace_));
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  Workspace& operator*() const { return *workspace_; }

 private:
  const SurfExtractor& extractor_;
  std::unique_ptr<Workspace> workspace_;
};

SurfExtractor::SurfExtractor(const SurfOptions& options, Simd simd)
    : options_(options), simd_(simd), descriptor_(simd) {
  if (const auto valid = options.validate(); !valid) {
    throw std::invalid_argument(valid.error().message);
  }
  if (!is_supported(simd)) {
    throw std::invalid_argument("SurfExtractor: this processor lacks the instructions");
  }
}

SurfExtractor::~SurfExtractor() = default;

Features SurfExtractor::extract(const image::GrayImage& image) const {
  constexpr float kWindow = 20;  // size_px over the scale
  const Lease lease(*this);
  auto& [pyramid, detector, blobs, keypoints, selection, order] = *lease;
  pyramid.build(image, options_.octaves, options_.doubled, simd_);
  blobs.clear();
  for (const SurfOctave& octave : pyramid.octaves()) {
    detector.find_blobs(octave, options_, simd_, blobs);
  }
  keypoints.clear();
  for (const Blob& blob : blobs) {
    Keypoint& keypoint = keypoints.emplace_back();
    keypoint.position_px = blob.position_px;
    keypoint.size_px = kWindow * blob.scale;
    keypoint.response = blob.response;
    keypoint.bright = blob.bright;
  }
  selection.select(keypoints, static_cast<std::size_t>(options_.max_keypoints), image.width(),
                   image.height(), options_.spread_cells);

  FloatDescriptors descriptors(keypoints.size(), SurfDescriptor::kValues);
  sort_by_place(keypoints, order);
  for (const std::size_t i : order) {
    Keypoint& keypoint = keypoints[i];
    const SurfOctave& octave = pyramid.octave_of_scale(keypoint.size_px / kWindow);
    const float x = octave.from_picture(keypoint.position_px.x());
    const float y = octave.from_picture(keypoint.position_px.y());
    const float scale = keypoint.size_px / kWindow / octave.pixel_size_px;
    if (!options_.upright) {
      keypoint.angle_rad = descriptor_.orientation_rad(octave.integral, x, y, scale);
    }
    descriptor_.describe(
        octave.integral, x, y, scale, keypoint.angle_rad,
        std::span<float, SurfDescriptor::kValues>(
            descriptors.row(static_cast<Eigen::Index>(i)).data(), SurfDescriptor::kValues));
  }
  return {keypoints, std::move(descriptors)};
}

}  // namespace roomwise::features
