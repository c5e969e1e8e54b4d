#pragma once

#include <cstdint>
#include <filesystem>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

struct WalkLog {
  std::uint64_t poses = 0;
  std::uint64_t pictures = 0;
  std::uint64_t points = 0;
  std::uint64_t things = 0;
  std::uint64_t keyframes_apart = 0;  // of the walk in other components: left out
};

// Writes a walk as an MCAP file with Foxglove's schemas, in JSON, for a viewer to play back:
//
//   /tf                  foxglove.FrameTransform     where the camera was, frame by frame: "camera"
//   in
//                                                    "home", which is the gravity-aligned frame
//   /camera/image        foxglove.CompressedImage    the pictures of the walk's key-frames, as
//   stored /camera/calibration  foxglove.CameraCalibration  the camera, beside each picture /map
//   foxglove.PointCloud         the home's map, one point a voxel, at the begin /things
//   foxglove.SceneUpdate        boxes and names of the home's things, likewise
//
// The file must be new, and is whole or not there. Fails where no key-frame of the walk is on the
// map's largest component, where pictures are protected by a passphrase that was not given, and
// when the user interrupts.
[[nodiscard]] Expected<WalkLog> write_walk_mcap(const home::Home& home, home::RecordingId walk,
                                                const std::filesystem::path& path,
                                                double voxel_size_m, RunContext& run);

}  // namespace roomwise::pipeline
