#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

// A phone focuses while it records, so that each picture has a camera of its own, and its depth
// images are smaller than its pictures. All are brought to one camera here. None of the cameras has
// a lens distortion: the phone has taken it out.
namespace roomwise::recording {

// The same camera for pictures of another size.
[[nodiscard]] geometry::PinholeCamera in_size(const geometry::PinholeCamera& camera, int width,
                                              int height);

// That of the depth image that belongs to a picture: ARKit's measures at the picture's pixels
// (0, 0), (s, 0), (2 s, 0), ..., not at the middles of the squares that its own pixels cover. (In a
// recording of a corridor edges in depth lie 0.4 px beside those in colour otherwise, both of
// things at the left and of things at the right.)
[[nodiscard]] geometry::PinholeCamera depth_camera(const geometry::PinholeCamera& camera, int width,
                                                   int height);

// Whether pictures of this size show what the camera's show, neither cut nor stretched: the sides
// have one ratio, but for a pixel of rounding.
[[nodiscard]] bool has_shape_of(const geometry::PinholeCamera& camera, int width, int height);

// The first of the sizes that most pictures have: one odd picture does not decide. There must be
// one.
using PictureSize = std::pair<int, int>;
[[nodiscard]] std::size_t first_of_most(std::span<const PictureSize> sizes);

// The median of the cameras, which are all of one size, for pictures of which no side is longer
// than `max_side_px`. There must be one.
[[nodiscard]] geometry::PinholeCamera common_camera(
    std::span<const geometry::PinholeCamera> cameras, int max_side_px);

// The picture that `to` would have taken in place of `from`: the mean of what each pixel covers. A
// border that `from` did not see repeats its outermost pixels.
[[nodiscard]] image::ColorImage as_seen_by(const image::ColorImage& picture,
                                           const geometry::PinholeCamera& from,
                                           const geometry::PinholeCamera& to);

// The same of a depth image: between measurements of one surface it follows the plane through them.
// 0 at the edge of a surface, where a phone's depth runs from one to the other and belongs to none,
// and where `from` did not see.
[[nodiscard]] image::DepthImage as_seen_by(const image::DepthImage& depth,
                                           const geometry::PinholeCamera& from,
                                           const geometry::PinholeCamera& to);

}  // namespace roomwise::recording
