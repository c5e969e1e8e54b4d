#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/mapping/cloud/ply_file.h"
#include "roomwise/pipeline/exports/dataset_pictures.h"
#include "roomwise/pipeline/exports/new_folder.h"
#include "roomwise/pipeline/mapping/home_floor.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Nerfstudio counts pixels from the corner of the top left one, we from its middle.
constexpr double kNerfstudioPixelMiddle = 0.5;

// Of a camera as OpenGL has it: x right, y up, looking along -z.
ordered_json transform_matrix(const geometry::RigidTransform& world_from_camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() =
      world_from_camera.rotation_matrix() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  matrix.topRightCorner<3, 1>() = world_from_camera.translation;
  ordered_json rows = ordered_json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  }
  return rows;
}

ordered_json frame_json(const DatasetView& view, const DatasetWalk& walk,
                        const geometry::RigidTransform& gravity_from_world) {
  const geometry::PinholeCamera& camera = walk.camera;
  const geometry::LensDistortion& lens = camera.distortion;
  const std::string depth = fs::path(view.picture).stem().string() + ".png";
  return {{"file_path", "images/" + view.picture},
          {"depth_file_path", "depths/" + depth},
          {"transform_matrix",
           transform_matrix(gravity_from_world * view.keyframe.pose.world_from_keyframe)},
          {"w", camera.width},
          {"h", camera.height},
          {"fl_x", camera.fx},
          {"fl_y", camera.fy},
          {"cx", camera.cx + kNerfstudioPixelMiddle},
          {"cy", camera.cy + kNerfstudioPixelMiddle},
          {"k1", lens.k1},
          {"k2", lens.k2},
          {"k3", lens.k3},
          {"p1", lens.p1},
          {"p2", lens.p2},
          {"walk", walk.name},
          {"time_s", seconds_between(0, view.keyframe.timestamp_ns)}};
}

Expected<void> write_transforms(const fs::path& folder, const PictureDataset& dataset,
                                const geometry::RigidTransform& gravity_from_world) {
  ordered_json json{{"camera_model", "OPENCV"},
                    {"ply_file_path", "sparse_pc.ply"},
                    {"frames", ordered_json::array()}};
  geometry::PointCloud cloud;
  for (const DatasetPoint& point : dataset.points) {
    cloud.add((gravity_from_world * point.point_world).cast<float>(), point.color);
  }
  for (const DatasetView& view : dataset.views) {
    json["frames"].push_back(frame_json(view, dataset.walks[view.walk], gravity_from_world));
  }
  ROOMWISE_RETURN_IF_ERROR(mapping::write_ply(folder / "sparse_pc.ply", cloud));
  return write_file(folder / "transforms.json",
                    json.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace

Expected<PictureDataset> write_nerfstudio(const home::Home& home, const fs::path& folder,
                                          const DatasetOptions& options, RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check_new_folder(folder));
  ROOMWISE_TRY(PictureDataset dataset, dataset_views(home, options));
  ROOMWISE_TRY(const HomeFloor floor, find_home_floor(home, run));
  ROOMWISE_RETURN_IF_ERROR(make_new_folder(folder, [&](const fs::path& partial) -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(write_dataset_pictures(home, {partial / "images", partial / "depths"},
                                                    options, dataset, run));
    return write_transforms(partial, dataset, floor.frame.gravity_from_world);
  }));
  return dataset;
}

}  // namespace roomwise::pipeline
