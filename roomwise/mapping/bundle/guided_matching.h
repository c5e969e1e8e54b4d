#pragma once

#include <span>
#include <vector>

#include "roomwise/mapping/bundle/feature_tracks.h"
#include "roomwise/mapping/bundle/landmarks.h"

namespace roomwise::mapping {

[[nodiscard]] bool is_in_picture(const Eigen::Vector3d& point_camera,
                                 const geometry::PinholeCamera& camera);

struct GuidedMatchingOptions {
  double search_px = 10;
  float max_distance = 127;  // between 8-bit descriptors
  float max_distance_ratio = 0.85F;
};

// Finds features of one key-frame again in another where their depth and the two poses expect them.
class GuidedMatcher {
 public:
  // The key-frames must outlive it.
  GuidedMatcher(std::span<const KeyframeFeatures> keyframes, const GuidedMatchingOptions& options);

  // Adds the matches between two key-frames: each other's nearest, or the nearest of one that the
  // other, having no depth, could not look for.
  void match(std::uint32_t a, std::uint32_t b, const geometry::RigidTransform& b_from_a,
             std::vector<FeatureMatch>& matches) const;

 private:
  // A picture's features by square cells as large as the search reaches.
  struct Cells {
    int columns = 0, rows = 0;
    std::vector<std::uint32_t> first;  // by cell, and the end
    std::vector<std::uint32_t> features;
  };
  struct Nearest {
    int feature = -1;  // of the other key-frame; -1: none
    float distance = 0;
  };
  [[nodiscard]] Cells cells_of(const KeyframeFeatures& keyframe) const;
  [[nodiscard]] int cell_along(double pixel) const;
  [[nodiscard]] std::vector<Nearest> find(std::uint32_t from, std::uint32_t to,
                                          const geometry::RigidTransform& to_from_from) const;
  [[nodiscard]] Nearest nearest(const KeyframeFeatures& from, std::size_t feature, std::uint32_t to,
                                const Eigen::Vector2d& expected) const;

  std::span<const KeyframeFeatures> keyframes_;
  GuidedMatchingOptions options_;
  std::vector<Cells> cells_;  // by key-frame
};

}  // namespace roomwise::mapping
