#include "roomwise/pipeline/exports/dataset_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/mapping/cloud/frame_cloud.h"
#include "roomwise/pipeline/exports/shared_picture.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kPixelStep = 4;
constexpr double kDatasetDepthUnitsPerMetre = 1000;

// In millimetres.
Bytes depth_file_of(const Bytes& stored, const image::DepthImage& depth,
                    const geometry::PinholeCamera& camera) {
  if (camera.depth_units_per_metre == kDatasetDepthUnitsPerMetre) return stored;
  image::DepthImage scaled(depth.width(), depth.height());
  const double scale = kDatasetDepthUnitsPerMetre / camera.depth_units_per_metre;
  std::ranges::transform(depth.pixels(), scaled.pixels().begin(), [&](std::uint16_t value) {
    const double units = std::round(value * scale);
    return units > std::numeric_limits<std::uint16_t>::max() ? std::uint16_t{0}
                                                             : static_cast<std::uint16_t>(units);
  });
  return image::encode_png(scaled);
}

// The points of a view; `view` is set by the caller.
std::vector<DatasetPoint> points_of(const DatasetView& view, const DecodedImages& images,
                                    const geometry::PinholeCamera& camera) {
  std::vector<DatasetPoint> points;
  const double farthest_m = mapping::FrameCloudOptions{}.farthest_m;
  for (int y = 0; y < camera.height; y += kPixelStep) {
    for (int x = 0; x < camera.width; x += kPixelStep) {
      const double z_m = images.depth.at(x, y) / camera.depth_units_per_metre;
      if (!(z_m > 0) || z_m > farthest_m) continue;
      points.push_back({view.keyframe.pose.world_from_keyframe * camera.unproject({x, y}, z_m),
                        images.color.at(x, y),
                        0,
                        {x, y}});
    }
  }
  return points;
}

struct ViewFiles {
  Bytes picture;
  Bytes depth;  // empty where it is not written
  std::vector<DatasetPoint> points;
};

Expected<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  return {};
}

}  // namespace

Expected<void> DatasetOptions::validate() const {
  if (!(voxel_size_m > 0)) return fail("voxel_size_m {} must be positive", voxel_size_m);
  return {};
}

Expected<PictureDataset> dataset_views(const home::Home& home, const DatasetOptions& options) {
  PictureDataset dataset;
  ROOMWISE_TRY(const auto recordings, walks_that_stay(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes) {
    if (options.walk && keyframe.recording != *options.walk) continue;
    const auto stored =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id);
    if (stored == recordings.end()) continue;
    if (keyframe.pose.component != 0) {
      ++dataset.keyframes_apart;
      continue;
    }
    auto walk = std::ranges::find(dataset.walks, keyframe.recording, &DatasetWalk::id);
    if (walk == dataset.walks.end()) {
      dataset.walks.push_back({stored->id, stored->recording.name, stored->recording.camera});
      walk = dataset.walks.end() - 1;
    }
    dataset.views.push_back(
        {keyframe, static_cast<std::size_t>(walk - dataset.walks.begin()), std::string()});
  }
  if (!dataset.views.empty()) return dataset;
  return options.walk
             ? fail("{}: no key-frame of that walk is on the map, or it is taken away",
                    home.file())
             : fail("{}: the home has no map yet; make one with roomwise map", home.file());
}

Expected<void> write_dataset_pictures(const home::Home& home, const DatasetFolders& folders,
                                      const DatasetOptions& options, PictureDataset& dataset,
                                      RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(make_folder(folders.pictures));
  if (!folders.depths.empty()) ROOMWISE_RETURN_IF_ERROR(make_folder(folders.depths));
  std::set<std::array<std::int64_t, 3>> voxels;
  return in_blocks(
      dataset.views.size(), "writing the pictures", run,
      [&](std::size_t i) { return home.images(dataset.views[i].keyframe.id); },
      [&](std::size_t i, const home::KeyframeImages& stored) -> Expected<ViewFiles> {
        const DatasetView& view = dataset.views[i];
        const geometry::PinholeCamera& camera = dataset.walks[view.walk].camera;
        ROOMWISE_TRY(const auto images,
                     in_context(fmt::format("{}: key-frame {}", home.file(), view.keyframe.id),
                                decode(stored, camera)));
        ROOMWISE_TRY(Bytes picture, picture_to_share(stored.color));
        return ViewFiles{
            std::move(picture),
            folders.depths.empty() ? Bytes() : depth_file_of(stored.depth, images.depth, camera),
            points_of(view, images, camera)};
      },
      [&](std::size_t i, ViewFiles files) -> Expected<void> {
        DatasetView& view = dataset.views[i];
        const std::string name =
            fmt::format("walk-{}-{:06}", view.walk + 1, view.keyframe.frame_index);
        view.picture = name + (image::is_png(files.picture) ? ".png" : ".jpg");
        ROOMWISE_RETURN_IF_ERROR(write_file(folders.pictures / view.picture, files.picture));
        if (!folders.depths.empty()) {
          ROOMWISE_RETURN_IF_ERROR(write_file(folders.depths / (name + ".png"), files.depth));
        }
        for (DatasetPoint& point : files.points) {
          const Eigen::Array3d voxel = (point.point_world.array() / options.voxel_size_m).floor();
          if (!voxels
                   .insert({static_cast<std::int64_t>(voxel.x()),
                            static_cast<std::int64_t>(voxel.y()),
                            static_cast<std::int64_t>(voxel.z())})
                   .second) {
            continue;
          }
          point.view = i;
          dataset.points.push_back(point);
        }
        return {};
      });
}

}  // namespace roomwise::pipeline
