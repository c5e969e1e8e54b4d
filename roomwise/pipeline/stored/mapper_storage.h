#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/image/rgbd_frame.h"
#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"

// How a mapper's state goes into a home and comes back. Features are not stored: they are found
// again in the stored images, which are those that the camera gave.
namespace roomwise::pipeline {

// The first key-frame of the walk that this recording is: the next one where it has none yet.
[[nodiscard]] home::KeyframeId first_keyframe_of(std::span<const home::Keyframe> keyframes,
                                                 home::RecordingId recording);

// What key-frames look like, as it was indexed before.
struct KnownAppearances {
  mapping::AppearanceIndex index;           // of 0, 1, 2, ...
  std::vector<home::KeyframeId> keyframes;  // which these are, ascending
};

// Gives the mapper of a walk, which begins or goes on, what the home holds of it and of the walks
// before it. Of those before whose appearance is known no picture is read before it is compared
// with; the home must outlive the mapper.
[[nodiscard]] Expected<void> restore_mapper(mapping::Mapper& mapper, const home::Home& home,
                                            home::RecordingId recording,
                                            const features::FeatureExtractor& extractor,
                                            const MapSettings& settings, RunContext& run,
                                            std::optional<KnownAppearances> known = std::nullopt);

// The images of a key-frame as a home keeps them. Nothing of them is lost: a resumed run finds its
// features in them again.
[[nodiscard]] home::KeyframeImages images_of(const image::RgbdFrame& frame);

// Writes what the mapper adds into the home, up to each new key-frame, and where none is made, up
// to a checkpoint now and then: a run that goes on from there sees the mapper in the state it had.
// Frames that are written are released. The home and the mapper must outlive it.
class MapWriter {
 public:
  // The mapper must hold what the home holds.
  [[nodiscard]] static Expected<MapWriter> create(home::Home& home, home::RecordingId recording,
                                                  mapping::Mapper& mapper);

  [[nodiscard]] home::KeyframeId first_keyframe() const { return first_keyframe_; }  // of the walk
  // Whether the home holds a key-frame of the walk.
  [[nodiscard]] bool has_begun() const { return poses_.size() > first_keyframe_; }

  // After each step; `frame_of` gives the images of its key-frames, by frame index.
  [[nodiscard]] Expected<void> write(
      const mapping::MapUpdate& step,
      const std::function<const image::RgbdFrame&(std::uint64_t)>& frame_of);

  // The frames after the last key-frame, when the recording has ended.
  [[nodiscard]] Expected<void> write_rest();

 private:
  MapWriter(home::Home& home, home::RecordingId recording, mapping::Mapper& mapper);

  // Where the next key-frame is as far as is known before the map is solved: along its first edge
  // to an earlier one of its walk, or in a new component of the map. A home that was left
  // unfinished shows its map so.
  [[nodiscard]] home::KeyframePose first_pose(mapping::KeyframeId id) const;
  // All that is not written yet, up to the frame before this index, with these key-frames.
  [[nodiscard]] Expected<void> commit(std::vector<home::NewKeyframe> keyframes,
                                      std::uint64_t next_frame_index);

  home::Home& home_;
  home::RecordingId recording_;
  mapping::Mapper& mapper_;
  home::KeyframeId first_keyframe_;  // of the walk
  std::size_t edges_written_;
  std::uint64_t frames_written_;           // of all that the mapper was given
  std::vector<home::KeyframePose> poses_;  // of the key-frames in the home, by id
};

}  // namespace roomwise::pipeline
