#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/geometry/oriented_box.h"
#include "roomwise/objects/instances.h"

namespace roomwise::objects {

// What may be a thing, by the map's depth alone: it stands apart from all else above some height.
struct Proposal {
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells, m
  geometry::OrientedBox box_world;             // upright
};

// What stands in the rooms once floor and walls are taken away (object proposals; that furniture
// stands apart when seen as pieces of a map's depth: A. Karpathy, S. Miller, L. Fei-Fei, "Object
// discovery in 3D scenes via shape analysis", 2013). Depth in cells of 5 cm that two key-frames or
// more show; columns that reach higher than furniture does are walls, and what is within a hand's
// breadth of them, too. At every 10 cm of height the cells above it fall into pieces: so a lamp is
// a piece above its nightstand's top, and a wardrobe above the bed's beside it. Pieces that hold
// most of one from lower down are that one, and what is like a door's leaf is none. From the
// largest of the lowest heights up.
[[nodiscard]] std::vector<Proposal> find_proposals(std::span<const LookedKeyframe> keyframes,
                                                   const Level& level);

// A key-frame that shows a proposal well.
struct ProposalView {
  std::size_t keyframe = 0;  // index of LookedKeyframe
  network::PixelBox box;     // about the proposal's box, cut at the picture's rim
  double quality = 0;        // how much of it shows, and how large
};
// The best first, eight at most: whose pictures hold most of the box, with most of its surface not
// hidden.
[[nodiscard]] std::vector<ProposalView> best_views(const Proposal& proposal,
                                                   std::span<const LookedKeyframe> keyframes);

}  // namespace roomwise::objects
