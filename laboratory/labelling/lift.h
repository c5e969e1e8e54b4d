#pragma once

#include <optional>
#include <span>

#include "laboratory/labelling/reader_labels.h"
#include "roomwise/geometry/oriented_box.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

// From boxes in pictures to a thing in space.
namespace roomwise::labelling {

// A reader's box with what is known of its picture.
struct PlacedView {
  network::PixelBox box;
  CutBorders cut;
  bool is_occluded = false;
  geometry::PinholeCamera camera;
  geometry::RigidTransform world_from_camera;
  std::optional<double> depth_m;  // along the optical axis, of what the middle of the box shows
};

// The median of the depths in the inner half (by side) of a box, m; absent where less than a fifth
// of it was measured.
[[nodiscard]] std::optional<double> depth_in_middle_m(const image::DepthImage& depth,
                                                      const geometry::PinholeCamera& camera,
                                                      const network::PixelBox& box);

struct LiftedThing {
  // Its axes are those of the camera that shows the thing best: x along the picture's rows, y along
  // its columns. The size along the optical axis, which one picture cannot show, is the smaller of
  // the other two.
  geometry::OrientedBox box_world;
  double sigma_m = 0;  // standard deviation of the middle along its least certain direction
  // Of the middle from those of the boxes, RMS over views that show all of it; absent where these
  // are not two, since one view fits by itself.
  std::optional<double> residual_px;
};

// The middle of a thing is where the rays through the middles of its boxes meet best (least squares
// of pixels; a border that cuts a box, or another thing that hides a part, leaves its middle as
// uncertain as the box is wide). The depth of its surface counts as a weak measurement of where it
// is, give or take the thing's own size: what depth shows of a chair with a bent tube for legs lies
// half a metre beside the chair. Absent where neither two directions nor a depth tell it.
[[nodiscard]] std::optional<LiftedThing> lift(std::span<const PlacedView> views);

}  // namespace roomwise::labelling
