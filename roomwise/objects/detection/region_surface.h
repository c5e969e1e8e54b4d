#pragma once

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/objects/detection/detection.h"

namespace roomwise::objects {

// The surface inside the box. Of the depths there, each weighted by how near it is to the box's
// middle, the fullest range is the thing's; from there the surface is followed to neighbouring
// places as long as the depth does not jump. Walls and floor that the thing touches stay with it:
// they are told apart by many views (see find_instances()).
[[nodiscard]] DetectionSurface region_surface(const image::DepthImage& depth,
                                              const geometry::PinholeCamera& camera,
                                              const network::PixelBox& box);

// The surface inside the box that lies within a box in space, whose "world" is the camera frame.
[[nodiscard]] DetectionSurface surface_within(const image::DepthImage& depth,
                                              const geometry::PinholeCamera& camera,
                                              const network::PixelBox& box,
                                              const geometry::OrientedBox& box_camera);

// The depth image with one place for eight by eight: the median of what was measured there (of a
// sample); 0 where less than a quarter was.
constexpr int kCoarseDepthStep_px = 8;
[[nodiscard]] image::DepthImage coarse_depth(const image::DepthImage& depth);

}  // namespace roomwise::objects
