#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"

namespace roomwise::objects {

// What depth says of a region of a picture: the surface of the thing that it shows, without what
// stands before and behind it. Camera frame, m.
struct RegionSurface {
  std::vector<Eigen::Vector3f>
      points;  // a sample of the surface, in the order of rows; may be none
  // The share of the region's measured places that lie on the surface, and of all its places that
  // were measured: [0, 1].
  float share = 0;
  float measured = 0;

  friend bool operator==(const RegionSurface&, const RegionSurface&) = default;
};

// How a region was found, the surest first.
enum class RegionSource {
  kDetector,    // by a network that gives boxes
  kCrop,        // by a classifier that is shown what is in a detector's box (crop_regions.h)
  kProposal,    // by networks that are shown what stands apart in depth (proposal_classifier.h)
  kActivation,  // by the class-activation maps of a classifier (activation_regions.h)
};

// Something that was found in a key-frame, and where it is.
struct Region {
  std::string label;  // as its finder calls it
  float score = 0;    // [0, 1]
  network::PixelBox box;
  RegionSurface surface;
  RegionSource source = RegionSource::kDetector;
};

// What was looked for and found in a key-frame.
struct KeyframeDetections {
  image::DepthImage coarse_depth;
  std::vector<Region> regions;  // best first
};

// The surface inside the box. Of the depths there, each weighted by how near it is to the box's
// middle, the fullest range is the thing's; from there the surface is followed to neighbouring
// places as long as the depth does not jump. Walls and floor that the thing touches stay with it:
// they are told apart by many views (see find_instances()).
[[nodiscard]] RegionSurface region_surface(const image::DepthImage& depth,
                                           const geometry::PinholeCamera& camera,
                                           const network::PixelBox& box);

// The surface inside the box that lies within a box in space, whose "world" is the camera frame.
[[nodiscard]] RegionSurface surface_within(const image::DepthImage& depth,
                                           const geometry::PinholeCamera& camera,
                                           const network::PixelBox& box,
                                           const geometry::OrientedBox& box_camera);

// The depth image with one place for eight by eight: the median of what was measured there (of a
// sample); 0 where less than a quarter was.
constexpr int kCoarseDepthStep_px = 8;
[[nodiscard]] image::DepthImage coarse_depth(const image::DepthImage& depth);

}  // namespace roomwise::objects
