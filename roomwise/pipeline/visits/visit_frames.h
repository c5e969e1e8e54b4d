#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/mapping/localization/localization.h"
#include "roomwise/objects/proposals/object_finders.h"
#include "roomwise/pipeline/objects/own_things.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/visits/visit_rooms.h"
#include "roomwise/recording/recording.h"

namespace roomwise::pipeline {

struct VisitOptions {
  std::uint64_t every = 1;  // of the visit's frames
  // Of more, evenly spread ones are looked at: their depth stays in memory, 0.6 MB each at 640x480.
  std::uint64_t max_frames = 2000;
  mapping::LocalizerOptions localizer;
  // How the learned rooms are refreshed; absent: they stay as they are.
  std::optional<rooms::VisitLearningOptions> rooms = rooms::VisitLearningOptions{};
  // Looks for what people taught; null: nobody does.
  std::shared_ptr<const OwnThingWatch> own_things = nullptr;

  [[nodiscard]] Expected<void> validate() const;
};

// What was recorded of a visit.
struct VisitRecording {
  const recording::Recording& recording;
  recording::FrameSource& frames;  // those of it that are looked at, from the next on
};

// A frame of a visit that was placed on the map.
struct PlacedFrame {
  std::uint64_t index = 0;  // in the recording
  TimestampNs timestamp_ns = 0;
  home::KeyframeId keyframe = 0;  // that shows the same
  image::DepthImage depth;
  std::optional<SeenPicture> room;  // where rooms are to be refreshed
};

// What a later walk through a home shows.
struct VisitFrames {
  home::Visit visit;
  std::vector<PlacedFrame> placed;  // in the order of time
  // The same as objects/ takes key-frames; their ids are places in `placed`.
  std::vector<objects::ObservedKeyframe> observed;
  std::optional<RoomUpdate> rooms;  // where they were to be refreshed
  OwnThingSightings own_things;     // where things that people taught were seen last
};

// Places the frames of a recording on the home's map, one by one, and lets the finders (one at
// least) look at those that were found there; then closer, from its best views, at what stands
// apart in their depth (objects::find_proposals), by frames as far apart as key-frames are; and
// looks for what people taught in as many as on a walk of the map.
// `level`: of the map. Fails where the home has no map, where the network is not among `networks`
// that its rooms were learned with, where the recording or a frame cannot be read, as the finders
// do, and when the user interrupts.
[[nodiscard]] Expected<VisitFrames> observe_visit(const home::Home& home,
                                                  const VisitRecording& visit,
                                                  const objects::ObjectFinders& finders,
                                                  const Networks& networks,
                                                  const objects::GroundPlane& level,
                                                  const VisitOptions& options, RunContext& run);

}  // namespace roomwise::pipeline
