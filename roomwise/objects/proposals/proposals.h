#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::objects {

// What may be a thing, by the map's depth alone.
struct Proposal {
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells of 5 cm, m
  geometry::OrientedBox box_world;             // upright
  double top_m = 0;                            // of the box, above the floor
};

// What stands in the rooms once floor and walls are taken away (object proposals; that furniture
// stands apart when seen as pieces of a map's depth: A. Karpathy, S. Miller, L. Fei-Fei, "Object
// discovery in 3D scenes via shape analysis", 2013): the pieces into which the cells above each
// height fall (components_above()). Columns that cross a height of 2.15 m are walls, so that of
// furniture that is higher nothing is left.
[[nodiscard]] std::vector<Proposal> find_proposals(std::span<const ObservedKeyframe> keyframes,
                                                   const GroundPlane& level);

// A key-frame that shows a proposal well.
struct ProposalView {
  std::size_t keyframe = 0;  // index of ObservedKeyframe
  network::PixelBox box;     // about the proposal's box, cut at the picture's rim
  double quality = 0;        // how much of it shows, and how large
};
// The best first, eight at most: whose pictures hold most of the box, and show a third of its
// surface or more.
[[nodiscard]] std::vector<ProposalView> best_views(const Proposal& proposal,
                                                   std::span<const ObservedKeyframe> keyframes);

}  // namespace roomwise::objects
