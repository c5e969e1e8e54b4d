#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/own_things/own_thing_finder.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/run_context.h"

// Things that people taught a home: taught, looked for in pictures, found on walks.
namespace roomwise::pipeline {

// A taught thing in a picture.
struct FoundOwnThing {
  home::OwnThingId id = 0;
  network::PixelBox box;
  double above = 0;  // log odds above the threshold from which on it counts as found
};

// All that is looked for in pictures of a home: values that never change. Thread-safe.
class OwnThingWatch {
 public:
  // Those that the picture shows. One network's features of OwnThingSearch::max_boxes places at
  // most, and each detector once, however many things there are.
  [[nodiscard]] Expected<std::vector<FoundOwnThing>> look(const image::ColorImage& picture) const;
  [[nodiscard]] const std::vector<home::OwnThing>& things() const { return things_; }

 private:
  friend class OwnThingWatchBuilder;
  OwnThingWatch() = default;
  std::vector<home::OwnThing> things_;
  std::unique_ptr<const objects::OwnThingFinder> finder_;
  std::vector<objects::PreparedThing> prepared_;  // by things_
  std::vector<double> thresholds_;                // likewise
};

// What looks for them: of the networks the first that names things, else the first; nullptr: none.
[[nodiscard]] const network::Classifier* network_of_own_things(const Networks& networks);

// Learns what is usual in pictures of the home, so that what looks like a thing is not taken for
// it: from at most kCalibrationPictures of its key-frames, evenly spread. Kept in the home as
// derived data, and made anew where key-frames, things or the network are others. Does nothing
// where no thing was taught. Fails where the home has too few key-frames or is locked, or no
// network is there.
constexpr std::size_t kCalibrationPictures = 100;
[[nodiscard]] Expected<void> calibrate_own_things(home::Home& home, const Networks& networks,
                                                  const objects::DetectionFinders& detectors,
                                                  RunContext& run);
// With what calibrate_own_things() kept; nullptr where no thing was taught. Fails where it is
// missing or stale. What it is given must outlive it.
[[nodiscard]] Expected<std::shared_ptr<const OwnThingWatch>> watch_own_things(
    const home::Home& home, const Networks& networks, const objects::DetectionFinders& detectors);

// Fails, with what to do, where the name would be taken for something else: a room of the home, or
// what its networks find.
[[nodiscard]] Expected<void> check_own_thing_name(const home::Home& home, const std::string& name);

// By six views at most, chosen of what was shown. `thing`: its name, owner, whether it is shared,
// and when. Fails as check_own_thing_name() and home::Home::add_own_thing() do, and where fewer
// than kMinPicturesShown pictures showed it.
constexpr std::size_t kMinPicturesShown = 3;
constexpr std::size_t kViewsOfAThing = 6;
[[nodiscard]] Expected<home::OwnThingId> teach_own_thing(home::Home& home, home::OwnThing thing,
                                                         std::span<const objects::ShownThing> shown,
                                                         const Networks& networks);

// A picture of a walk in which they are looked for.
struct OwnThingPicture {
  const image::ColorImage& color;
  const image::DepthImage& depth;
  const geometry::PinholeCamera& camera;
  TimestampNs timestamp_ns = 0;
  home::KeyframeId keyframe = 0;  // beside which it was taken
  geometry::RigidTransform keyframe_from_camera = {};
};
// Where those that a picture shows are: each beside the key-frame. Thread-safe.
using OwnThingSightings = std::map<home::OwnThingId, home::OwnThingSighting>;
[[nodiscard]] Expected<OwnThingSightings> own_things_in(const OwnThingPicture& picture,
                                                        const OwnThingWatch& watch);
// In how many pictures of a walk they are looked for at most, evenly spread.
constexpr std::size_t kWalkPictures = 200;

// Looks for them on a walk that is mapped: where each was seen last.
[[nodiscard]] Expected<OwnThingSightings> find_own_things(const home::Home& home,
                                                          home::RecordingId walk,
                                                          const OwnThingWatch& watch,
                                                          RunContext& run);
// Notes where they were seen on a walk, unless the home knows of a later sighting, or of this one;
// of how many it was noted.
[[nodiscard]] Expected<std::size_t> note_own_things(home::Home& home,
                                                    const OwnThingSightings& seen);

// What became of looking for taught things.
struct OwnThingLook {
  bool is_looked_for = true;  // false: what is usual in the home is not known
  std::string why;            // then
  std::size_t seen = 0;       // things, on the newest walk
};
// Learns what is usual, where that is not known, then looks on the newest walk. Fails only where
// the home cannot be written or the user interrupts.
[[nodiscard]] Expected<OwnThingLook> look_for_own_things(home::Home& home, const Networks& networks,
                                                         const objects::DetectionFinders& detectors,
                                                         RunContext& run);

// The middle of what a box shows, in the camera's frame, by the median of the depth in its inner
// third; nothing where none was measured there.
[[nodiscard]] std::optional<Eigen::Vector3d> middle_by_depth(const image::DepthImage& depth,
                                                             const geometry::PinholeCamera& camera,
                                                             const network::PixelBox& box);

}  // namespace roomwise::pipeline
