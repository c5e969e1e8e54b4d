#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/objects/instances/instances.h"

// What became of the things of a home since it was mapped: a later visit's pictures beside those of
// the map, all in one world.
namespace roomwise::objects {

// A depth image whose pose is known.
struct DepthView {
  geometry::RigidTransform world_from_camera;
  const geometry::PinholeCamera* camera = nullptr;
  const image::DepthImage* depth = nullptr;
  int step_px = 1;  // of the camera's picture, that one place of the depth image stands for
};

// What depth images say of a surface that once was seen.
struct FreeSpaceEvidence {
  std::size_t points = 0;   // of the surface
  std::size_t decided = 0;  // of these, those that the views say something of
  std::size_t gone = 0;     // of the decided ones, those through which more views look than see it
  int views = 0;            // that decide a quarter of the points or more

  // Shares in [0, 1]; of nothing: 0.
  [[nodiscard]] double decided_share() const;
  [[nodiscard]] double gone_share() const;
  [[nodiscard]] double gone_share_of_whole() const;
};
// A view sees a point where the depth around it is the point's, and looks through it where all that
// is measured around it lies behind. What is hidden, outside of the picture or not measured says
// nothing.
[[nodiscard]] FreeSpaceEvidence surface_evidence(std::span<const Eigen::Vector3f> surface_world,
                                                 std::span<const DepthView> views);
// The points that are not gone.
[[nodiscard]] std::vector<Eigen::Vector3f> remaining_surface(
    std::span<const Eigen::Vector3f> surface_world, std::span<const DepthView> views);

// A thing and where it stands.
struct PlacedInstance {
  std::string name;
  geometry::OrientedBox box_world;             // upright
  std::vector<Eigen::Vector3f> surface_world;  // a sample; may be none
};

// The thing of an instance. Its surface is what the key-frames' detections of its names show inside
// its box, but for what it stands on; `supporting_keyframes` gets the key-frames' places in the
// span, ascending.
[[nodiscard]] PlacedInstance placed_instance(
    const Instance& instance, const geometry::OrientedBox& box_world,
    std::span<const ObservedKeyframe> keyframes, const GroundPlane& level,
    std::vector<std::size_t>* supporting_keyframes = nullptr);

enum class ChangeState {
  kThere,       // where it was
  kMoved,       // stands elsewhere now
  kShifted,     // was pushed or turned: only a part is where it was, and it was not found again
  kRemoved,     // and nothing of its kind is new
  kUnobserved,  // the visit did not show enough of its place to say
};
[[nodiscard]] std::string_view to_string(ChangeState state);

// Of what was shifted and not found again: so much less sure is its place along the floor, m.
constexpr double kShiftSigma_m = 0.2;

struct InstanceChange {
  ChangeState state = ChangeState::kUnobserved;
  FreeSpaceEvidence evidence;      // of the visit's depth
  std::optional<std::size_t> now;  // of the visit's things, the one that it is
  FreeSpaceEvidence
      evidence_now;  // of that one, by the map's depth: gone is what was not there yet
};
struct ArrivedInstance {
  std::size_t now = 0;         // of the visit's things
  FreeSpaceEvidence evidence;  // of the map's depth: gone is what was not there yet
};
struct Changes {
  std::vector<InstanceChange> before;    // as the things that were given
  std::vector<ArrivedInstance> arrived;  // and not moved there from elsewhere in the home
};

struct ChangeOptions {
  double min_decided = 0.3;  // of the surface; less was not looked at
  int min_views = 2;         // that looked at it
  double min_gone = 0.6;     // of the decided surface; the same of what is new
  double min_moved_gone_share =
      0.12;  // the same, of both surfaces of what is found again nearly there
  double min_shifted_gone_share =
      0.15;  // the same, of what is not found again but still there in part
  double min_moved_distance_m = 0.08;  // less is no move
  // The three shares above are of the whole surface: what no view decides counts as still there.
  bool of_whole_surface = false;
  // A thing in the place of another has this share of its surface in the other's box or more.
  double same_place = 0.3;

  [[nodiscard]] Expected<void> validate() const;
};

// What became of the things `before`, and which of those of the visit, `now`, are new.
//
// 1. A thing of the visit and one before that share their place and name are one. It was moved if
//    depth says of both surfaces that much is not where the other walk showed it, and the middles
//    differ; it is there otherwise.
// 2. Of the others before, what the visit's depth looks through is gone, what it sees is there, and
//    what it looks through in part was shifted, where its kind is not fixed to the house.
// 3. Of the others now, what the map's depth looks through is new, and so is what stands where a
//    thing of its name stood in the `past`, which the map's depth shows still. The rest stood there
//    before without a name.
// 4. What is gone and what is new by one name are one thing that moved: the nearest pair first.
//
// Same input, same result, whatever the order of views.
[[nodiscard]] Changes find_changes(std::span<const PlacedInstance> before,
                                   std::span<const DepthView> views_before,
                                   std::span<const PlacedInstance> now,
                                   std::span<const DepthView> views_now,
                                   std::span<const PlacedInstance> past,
                                   const ChangeOptions& options);

// Which of the things stood where each of the past ones did, by name and nearness, each used once;
// of nothing: absent.
[[nodiscard]] std::vector<std::optional<std::size_t>> match_by_name_and_place(
    std::span<const PlacedInstance> past, std::span<const PlacedInstance> things);

}  // namespace roomwise::objects
