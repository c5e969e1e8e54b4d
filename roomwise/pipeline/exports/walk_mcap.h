#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

struct WalkLog {
  std::uint64_t poses = 0;
  std::uint64_t pictures = 0;
  std::uint64_t points = 0;
  std::uint64_t things = 0;
  std::uint64_t rooms = 0;
  std::uint64_t prompts = 0;
  std::uint64_t keyframes_apart = 0;  // of the walk in other components: left out
};

struct WalkLogOptions {
  double voxel_size_m = 0.02;
  std::string language = "en";  // of prompts
};

// Writes a walk as an MCAP file with Foxglove's schemas, in JSON, for a viewer to play back, in the
// gravity-aligned frame "home":
//
//   /tf                  foxglove.FrameTransform     where the camera was, frame by frame: "camera"
//   /camera/image        foxglove.CompressedImage    the walk's key-frames' pictures, as stored
//   /camera/calibration  foxglove.CameraCalibration  the camera, beside each picture
//   /prompts             foxglove.Log                what is said where the walk comes into a room
//   /map                 foxglove.PointCloud         one point a voxel, at the begin
//   /things              foxglove.SceneUpdate        boxes and names of things, likewise
//   /rooms               foxglove.SceneUpdate        outlines and names of rooms, likewise
//
// What the home has nothing of has no topic. The file must be new, and is whole or not there. Fails
// where no key-frame of the walk is on the map's largest component, where pictures are protected by
// a passphrase that was not given, where the language is not spoken, and when the user interrupts.
[[nodiscard]] Expected<WalkLog> write_walk_mcap(const home::Home& home, home::RecordingId walk,
                                                const std::filesystem::path& path,
                                                const WalkLogOptions& options, RunContext& run);

}  // namespace roomwise::pipeline
