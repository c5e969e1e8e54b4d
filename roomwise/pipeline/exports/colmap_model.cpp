#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/pipeline/exports/dataset_pictures.h"
#include "roomwise/pipeline/exports/new_folder.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;

// COLMAP counts pixels from the corner of the top left one, we from its middle.
constexpr double kColmapPixelMiddle = 0.5;

// A name on one line of a comment, whatever is in it.
std::string in_comment(const std::string& name) {
  return nlohmann::json(name).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string camera_line(std::size_t id, const geometry::PinholeCamera& camera) {
  const geometry::LensDistortion& lens = camera.distortion;
  std::string line;
  const auto add = [&](const auto&... values) { ((line += fmt::format(" {}", values)), ...); };
  add(camera.width, camera.height, camera.fx, camera.fy, camera.cx + kColmapPixelMiddle,
      camera.cy + kColmapPixelMiddle);
  std::string model = "PINHOLE";
  if (!lens.is_none()) {
    model = "OPENCV";
    add(lens.k1, lens.k2, lens.p1, lens.p2);
  }
  if (lens.k3 != 0) {
    model = "FULL_OPENCV";
    add(lens.k3, 0, 0, 0);
  }
  return fmt::format("{} {}{}\n", id, model, line);
}

std::string cameras_file(const PictureDataset& dataset) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < dataset.walks.size(); ++i) {
    text += fmt::format("# of the walk {}\n", in_comment(dataset.walks[i].name));
    text += camera_line(i + 1, dataset.walks[i].camera);
  }
  return text;
}

// An image has two lines: its pose, and what it sees. The latter is empty where it sees nothing.
std::string images_file(const PictureDataset& dataset) {
  std::vector<std::string> seen(dataset.views.size());
  for (std::size_t i = 0; i < dataset.points.size(); ++i) {
    const DatasetPoint& point = dataset.points[i];
    std::string& line = seen[point.view];
    if (!line.empty()) line += ' ';
    line += fmt::format("{} {} {}", point.pixel.x() + kColmapPixelMiddle,
                        point.pixel.y() + kColmapPixelMiddle, i + 1);
  }
  std::string text =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (std::size_t i = 0; i < dataset.views.size(); ++i) {
    const DatasetView& view = dataset.views[i];
    const geometry::RigidTransform camera_from_world =
        view.keyframe.pose.world_from_keyframe.inverse();
    const Eigen::Quaterniond& q = camera_from_world.rotation;
    const Eigen::Vector3d& t = camera_from_world.translation;
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}\n{}\n", i + 1, q.w(), q.x(), q.y(), q.z(),
                        t.x(), t.y(), t.z(), view.walk + 1, view.picture, seen[i]);
  }
  return text;
}

std::string points_file(const PictureDataset& dataset) {
  std::string text =
      "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
      "# each is what one pixel measured: it reprojects without an error\n";
  std::vector<std::size_t> seen(dataset.views.size(), 0);
  for (std::size_t i = 0; i < dataset.points.size(); ++i) {
    const DatasetPoint& point = dataset.points[i];
    const Eigen::Vector3d& at = point.point_world;
    text +=
        fmt::format("{} {} {} {} {} {} {} 0 {} {}\n", i + 1, at.x(), at.y(), at.z(), point.color.r,
                    point.color.g, point.color.b, point.view + 1, seen[point.view]++);
  }
  return text;
}

Expected<void> write_colmap_text(const fs::path& folder, const PictureDataset& dataset) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "cameras.txt", cameras_file(dataset)));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "images.txt", images_file(dataset)));
  return write_file(folder / "points3D.txt", points_file(dataset));
}

}  // namespace

Expected<PictureDataset> write_colmap(const home::Home& home, const fs::path& folder,
                                      const DatasetOptions& options, RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check_new_folder(folder));
  ROOMWISE_TRY(PictureDataset dataset, dataset_views(home, options));
  ROOMWISE_RETURN_IF_ERROR(make_new_folder(folder, [&](const fs::path& partial) -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        write_dataset_pictures(home, {partial / "images", {}}, options, dataset, run));
    return write_colmap_text(partial / "sparse" / "0", dataset);
  }));
  return dataset;
}

}  // namespace roomwise::pipeline
