#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/motion/focal_length_fit.h"
#include "roomwise/objects/proposals/object_finders.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::pipeline {

struct MapSummary {
  std::uint64_t frames = 0;
  std::uint64_t placed = 0;              // frames that have a pose in the map's largest component
  std::uint64_t with_device_motion = 0;  // frames whose device tells its own motion
  std::uint64_t motion_dropped = 0;      // of these, those where pictures contradict it
  std::uint64_t motion_alone = 0;        // of these, those that are placed by it alone
  std::uint64_t felt_up = 0;             // frames at which the device feels gravity
  // Of all walks' key-frames, those at which it was dropped: what is level contradicts it.
  std::uint64_t contradicted_gravity = 0;
  bool is_by_inertial_sensor = false;  // the device's motion is a gyroscope's turns
  std::uint64_t keyframes = 0;         // of this walk
  std::uint64_t edges = 0;             // of the pose graph, all walks' together
  std::uint64_t loops = 0;  // returns to a place that was left: edges over more than ten key-frames
  std::uint64_t rejected_edges = 0;  // edges that contradicted the others and were left out
  std::uint64_t components = 0;
  std::uint64_t walks = 0;    // in the home
  std::uint64_t culled = 0;   // key-frames of the walk before this one that went
  bool is_joined = true;      // the walk shares a component with an earlier one, where there is one
  std::uint64_t objects = 0;  // by the paper's rules
  std::uint64_t instances = 0;    // joined from the regions of many key-frames
  double graph_error_before = 0;  // F of the pose graph
  double graph_error_after = 0;
  // Where the bundle was adjusted; else 0.
  std::uint64_t landmarks = 0;
  std::uint64_t landmark_views = 0;
  std::optional<double> readout_s;  // of the camera's rolling shutter, where frames tell it
  std::optional<motion::FocalLengthFit> focal_length;  // that the pictures fit, where they tell
  // Why key-frames could not be read that would have told whether the walk shows a place that the
  // map knows.
  std::vector<std::string> unread;
  bool finished =
      false;  // false: interrupted, or the recording gave an error; the home goes on from there
};

// The main job: frames -> key-frames -> loops -> pose graph -> objects, all into a home. A home
// that holds an unfinished recording is gone on with, exactly as if it had never been stopped. A
// finished one stays, and the recording is a further walk, with a camera of its own: it joins the
// map where it shows the same, else it is a component of its own, which a later walk may join. Then
// key-frames of the walk before go that add nothing to what the walks before that one show
// (culling.h), where the settings say so. The settings must be the home's own, where it has some; a
// recording that it holds already is an error. Networks and finders may be empty: then nothing is
// named or learned, or found. `inertial` is what an inertial sensor felt along this walk, where the
// frames tell no motion themselves; a run that goes on needs the same. On an error of the source (a
// damaged image) everything before it is in the home. `name_rooms`, if given, is done in one
// transaction with what finishes the walk: who is killed finds both or none.
[[nodiscard]] Expected<MapSummary> map_recording(
    recording::FrameSource& source, const home::Recording& recording, home::Home& home,
    const Networks& networks, const MapSettings& settings, RunContext& run,
    const objects::ObjectFinders& finders = {},
    const std::function<Expected<void>()>& name_rooms = nullptr,
    const geometry::InertialTrack& inertial = {});

}  // namespace roomwise::pipeline
