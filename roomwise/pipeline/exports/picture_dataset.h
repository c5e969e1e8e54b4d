#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

// A home's key-frames as pictures with poses, for programs that make scenes of such: COLMAP,
// Nerfstudio, Gaussian splatting.
namespace roomwise::pipeline {

struct DatasetOptions {
  std::optional<home::RecordingId> walk;  // of this one alone; absent: of all
  double voxel_size_m = 0.05;             // one point at most in a voxel of this size

  [[nodiscard]] Expected<void> validate() const;
};

// A key-frame of the map's largest component.
struct DatasetView {
  home::Keyframe keyframe;
  std::size_t walk = 0;  // index into DatasetWalk
  std::string picture;   // name of its file: letters, digits, '-' and '.'
};

struct DatasetWalk {
  home::RecordingId id = 0;
  std::string name;
  geometry::PinholeCamera camera;  // of all its pictures
};

// What a pixel of a view measured, in the map's world.
struct DatasetPoint {
  Eigen::Vector3d point_world;
  Rgb8 color;
  std::size_t view = 0;
  Eigen::Vector2i pixel;
};

struct PictureDataset {
  std::vector<DatasetWalk> walks;  // those that have views
  std::vector<DatasetView> views;  // by id of the key-frame
  std::vector<DatasetPoint> points;
  std::size_t keyframes_apart = 0;  // in other components: no view of them
};

// Writes a COLMAP model, as text, with its pictures: FOLDER/images/*, FOLDER/sparse/0/cameras.txt,
// images.txt and points3D.txt, in the map's world. A camera without a lens is PINHOLE, one with k3
// FULL_OPENCV, any other OPENCV. Each point is seen by the view that measured it. Source: COLMAP's
// documentation, "Output Format".
//
// Pictures are written as they are stored; one with Exif, which says how to turn it and may say
// where it was taken, as PNG without. The folder must be new, and is whole or not there. Fails
// where the home has no map, where pictures are protected by a passphrase that was not given, and
// when the user interrupts.
[[nodiscard]] Expected<PictureDataset> write_colmap(const home::Home& home,
                                                    const std::filesystem::path& folder,
                                                    const DatasetOptions& options, RunContext& run);

// The same as Nerfstudio reads it: FOLDER/transforms.json with a camera for each frame, pictures in
// images/, depth in depths/ (16-bit PNG, mm along the optical axis, 0 where nothing was measured;
// to 65.535 m), the points in sparse_pc.ply. World and points are in the gravity-aligned frame, z
// up. Source: Nerfstudio's documentation, "Data conventions".
[[nodiscard]] Expected<PictureDataset> write_nerfstudio(const home::Home& home,
                                                        const std::filesystem::path& folder,
                                                        const DatasetOptions& options,
                                                        RunContext& run);

}  // namespace roomwise::pipeline
