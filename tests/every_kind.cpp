#include "every_kind.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"
#include "roomwise/recording/bytes/testing/exr_writer.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/phone/testing/record3d_writer.h"
#include "roomwise/recording/phone/testing/video_writer.h"
#include "roomwise/recording/robot/testing/robot_log.h"
#include "roomwise/recording/sens/testing/sens_writer.h"

namespace roomwise::testing {
namespace {

namespace fs = std::filesystem;
namespace made = recording::testing;
using nlohmann::json;

// A made-up recording, and what all kinds are written of.
struct SourceWalk {
  fs::path folder;  // its own
  geometry::PinholeCamera camera;
  std::vector<image::RgbdFrame> frames;
  std::vector<Eigen::Vector3d> places;  // x right, y down; the camera does not turn

  [[nodiscard]] double seconds(std::size_t i) const {
    return static_cast<double>(frames[i].timestamp_ns) * kSecondsPerNs;
  }
  [[nodiscard]] Bytes jpeg(std::size_t i) const { return image::encode_jpeg(frames[i].color, 95); }
  [[nodiscard]] Bytes depth_png(std::size_t i) const { return image::encode_png(frames[i].depth); }
};

Expected<SourceWalk> read_source_walk(const fs::path& folder) {
  SourceWalk walk;
  walk.folder = folder;
  ROOMWISE_TRY(const auto source, recording::open_recording(folder));
  ROOMWISE_TRY(const auto truth, recording::read_truth(folder));
  walk.camera = source->info().camera;
  for (std::size_t i = 0; i < source->frames().size(); ++i) {
    ROOMWISE_TRY(auto frame, source->frame(source->frames()[i]));
    walk.frames.push_back(*std::move(frame));
    walk.places.push_back(truth[i].world_from_camera.translation);
  }
  return walk;
}

Expected<void> put(const fs::path& file, std::span<const std::uint8_t> bytes) {
  std::error_code ignored;
  fs::create_directories(file.parent_path(), ignored);
  return write_file(file, bytes);
}
Expected<void> put(const fs::path& file, const std::string& text) {
  return put(file, made::bytes_of(text));
}

Expected<fs::path> write_tum(const SourceWalk& walk, const fs::path& folder) {
  std::error_code error;
  fs::copy(walk.folder, folder, fs::copy_options::recursive, error);
  if (error) return fail("{}", error.message());
  return folder;
}

// A camera of ARKit has y up and z back, and so has its world here.
std::array<double, 12> arkit_pose(const Eigen::Vector3d& place) {
  return {1, 0, 0, place.x(), 0, 1, 0, -place.y(), 0, 0, 1, -place.z()};
}

Expected<fs::path> write_scanner_app(const SourceWalk& walk, const fs::path& folder) {
  const geometry::PinholeCamera& camera = walk.camera;
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    json pose = arkit_pose(walk.places[i]);
    for (const int last : {0, 0, 0, 1}) pose.push_back(last);
    const json frame{{"time", walk.seconds(i)},
                     {"intrinsics", {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
                     {"cameraPoseARFrame", pose}};
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("frame_{:05}.json", i), frame.dump()));
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("frame_{:05}.jpg", i), walk.jpeg(i)));
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("depth_{:05}.png", i), walk.depth_png(i)));
  }
  return folder;
}

Expected<fs::path> write_stray_scanner(const SourceWalk& walk, const fs::path& folder) {
  const geometry::PinholeCamera& camera = walk.camera;
  const auto luma = [&](int i, int x, int y) {
    return walk.frames[static_cast<std::size_t>(i)].color.at(x, y).g;
  };
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  if (!made::write_video(folder / "rgb.mp4", static_cast<int>(walk.frames.size()), luma,
                         AV_CODEC_ID_MPEG4, 6, camera.width, camera.height)) {
    return fail("the video cannot be written");
  }
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    odometry += fmt::format("{}, {:06}, {}, {}, 0, 1, 0, 0, 0\n", walk.seconds(i), i,
                            walk.places[i].x(), -walk.places[i].y());
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("depth/{:06}.png", i), walk.depth_png(i)));
  }
  ROOMWISE_RETURN_IF_ERROR(put(folder / "odometry.csv", odometry));
  ROOMWISE_RETURN_IF_ERROR(put(
      folder / "camera_matrix.csv",
      fmt::format("{}, 0, {}\n0, {}, {}\n0, 0, 1\n", camera.fx, camera.cx, camera.fy, camera.cy)));
  return folder;
}

Expected<fs::path> write_polycam(const SourceWalk& walk, const fs::path& folder) {
  const fs::path keyframes = folder / "keyframes";
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    const std::string name = std::to_string(walk.frames[i].timestamp_ns / 1000);
    json camera{{"fx", walk.camera.fx},       {"fy", walk.camera.fy},
                {"cx", walk.camera.cx},       {"cy", walk.camera.cy},
                {"width", walk.camera.width}, {"height", walk.camera.height}};
    const auto pose = arkit_pose(walk.places[i]);
    for (std::size_t one = 0; one < pose.size(); ++one) {
      camera[fmt::format("t_{}{}", one / 4, one % 4)] = pose[one];
    }
    ROOMWISE_RETURN_IF_ERROR(put(keyframes / "cameras" / (name + ".json"), camera.dump()));
    ROOMWISE_RETURN_IF_ERROR(put(keyframes / "images" / (name + ".jpg"), walk.jpeg(i)));
    ROOMWISE_RETURN_IF_ERROR(put(keyframes / "depth" / (name + ".png"), walk.depth_png(i)));
  }
  return folder;
}

Expected<fs::path> write_arkitscenes(const SourceWalk& walk, const fs::path& folder) {
  std::string path;
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    const std::string name = fmt::format("4242_{:.3f}", walk.seconds(i));
    const geometry::PinholeCamera& camera = walk.camera;
    ROOMWISE_RETURN_IF_ERROR(
        put(folder / "lowres_wide" / (name + ".png"), image::encode_png(walk.frames[i].color)));
    ROOMWISE_RETURN_IF_ERROR(put(folder / "lowres_depth" / (name + ".png"), walk.depth_png(i)));
    ROOMWISE_RETURN_IF_ERROR(put(folder / "lowres_wide_intrinsics" / (name + ".pincam"),
                                 fmt::format("{} {} {} {} {} {}\n", camera.width, camera.height,
                                             camera.fx, camera.fy, camera.cx, camera.cy)));
    const Eigen::Vector3d back = -walk.places[i];
    path += fmt::format("{} 0 0 0 {} {} {}\n", walk.seconds(i), back.x(), back.y(), back.z());
  }
  ROOMWISE_RETURN_IF_ERROR(put(folder / "lowres_wide.traj", path));
  return folder;
}

// As a camera of 7-Scenes sees it, whose focal length is 525 px and whose middle is (320, 240).
image::ColorImage of_seven_scenes(const image::ColorImage& color,
                                  const geometry::PinholeCamera& camera) {
  const double scale = camera.fx / 525;
  const double left = camera.cx + 0.5 - 320.5 * scale, top = camera.cy + 0.5 - 240.5 * scale;
  return image::resize(color, {left, top, left + 640 * scale, top + 480 * scale}, 640, 480);
}

Expected<fs::path> write_seven_scenes(const SourceWalk& walk, const fs::path& folder) {
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    const std::string name = fmt::format("frame-{:06}", i);
    const Eigen::Vector3d& place = walk.places[i];
    ROOMWISE_RETURN_IF_ERROR(
        put(folder / (name + ".color.png"),
            image::encode_png(of_seven_scenes(walk.frames[i].color, walk.camera))));
    ROOMWISE_RETURN_IF_ERROR(
        put(folder / (name + ".depth.png"),
            image::encode_png(image::DepthImage(640, 480, walk.frames[i].depth.at(0, 0)))));
    ROOMWISE_RETURN_IF_ERROR(put(
        folder / (name + ".pose.txt"),
        fmt::format("1 0 0 {}\n0 1 0 {}\n0 0 1 {}\n0 0 0 1\n", place.x(), place.y(), place.z())));
  }
  return folder;
}

recording::testing::LogPlan robot_log(const SourceWalk& walk, recording::Encoding encoding) {
  made::RobotLog log(encoding);
  const auto width = static_cast<std::uint32_t>(walk.camera.width);
  const auto height = static_cast<std::uint32_t>(walk.camera.height);
  for (const char* topic : {"/camera/color/camera_info", "/camera/depth/camera_info"}) {
    log.info(topic, "camera", walk.camera.fx, width, height);
  }
  for (const image::RgbdFrame& frame : walk.frames) {
    const TimestampNs time = made::kStart + frame.timestamp_ns;
    made::ByteWriter color, depth;
    for (const Rgb8& one : frame.color.pixels()) {
      for (const std::uint8_t part : {one.r, one.g, one.b}) color.number<std::uint8_t>(part);
    }
    for (const std::uint16_t one : frame.depth.pixels()) depth.number<std::uint16_t>(one);
    log.image("/camera/color/image_raw", time, "camera", "rgb8", width, height, color.all());
    log.image("/camera/depth/image_raw", time, "camera", "16UC1", width, height, depth.all());
  }
  return log.plan();
}

Expected<fs::path> write_mcap(const SourceWalk& walk, const fs::path& folder) {
  ROOMWISE_RETURN_IF_ERROR(put(
      folder / "walk.mcap", made::McapWriter::write(robot_log(walk, recording::Encoding::kCdr))));
  return folder / "walk.mcap";
}

Expected<fs::path> write_bag(const SourceWalk& walk, const fs::path& folder) {
  ROOMWISE_RETURN_IF_ERROR(put(
      folder / "walk.bag", made::BagWriter::write(robot_log(walk, recording::Encoding::kRos1))));
  return folder / "walk.bag";
}

Expected<fs::path> write_sens(const SourceWalk& walk, const fs::path& folder) {
  made::SensPlan plan;
  plan.color_width = walk.camera.width;
  plan.color_height = walk.camera.height;
  plan.color_focal_ratio = walk.camera.fx / walk.camera.width;
  plan.depth_mm = walk.frames.front().depth.at(0, 0);
  plan.frame_count = walk.frames.size();
  for (std::size_t i = 0; i < walk.frames.size(); ++i) plan.colors.push_back(walk.jpeg(i));
  ROOMWISE_RETURN_IF_ERROR(put(folder / "walk.sens", made::sens_file(plan)));
  return folder / "walk.sens";
}

// Of a Record3D recording held across: its depth is as large as that of the upright one.
constexpr int kDepthWidth = made::kDepthHeight, kDepthHeight = made::kDepthWidth;
std::string record3d_metadata(const SourceWalk& walk) {
  json metadata{
      {"w", walk.camera.width},
      {"h", walk.camera.height},
      {"dw", kDepthWidth},
      {"dh", kDepthHeight},
      {"fps", 10},
      {"K", {walk.camera.fx, 0, 0, 0, walk.camera.fy, 0, walk.camera.cx, walk.camera.cy, 1}},
      {"cameraType", 1}};
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    const auto pose = arkit_pose(walk.places[i]);
    metadata["frameTimestamps"].push_back(walk.seconds(i));
    metadata["poses"].push_back({0, 0, 0, 1, pose[3], pose[7], pose[11]});
  }
  return metadata.dump();
}

float wall_distance_m(const SourceWalk& walk) {
  return static_cast<float>(walk.frames.front().depth.at(0, 0) / walk.camera.depth_units_per_metre);
}

Expected<fs::path> write_record3d(const SourceWalk& walk, const fs::path& folder) {
  made::ZipContents files{{"metadata", made::bytes_of(record3d_metadata(walk))}};
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    const std::string name = fmt::format("rgbd/{}", i);
    files[name + ".jpg"] = walk.jpeg(i);
    files[name + ".depth"] = made::lzfse(made::depth_of_metres(wall_distance_m(walk)));
    files[name + ".conf"] = made::lzfse(Bytes(made::kDepthWidth * made::kDepthHeight, 2));
  }
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  if (!made::write_zip(folder / "walk.r3d", files)) return fail("the zip cannot be written");
  return folder / "walk.r3d";
}

Expected<fs::path> write_record3d_exr(const SourceWalk& walk, const fs::path& folder) {
  made::ExrPlan depth;
  depth.width = kDepthWidth;
  depth.height = kDepthHeight;
  depth.value = [metres = wall_distance_m(walk)](std::size_t, int, int) { return metres; };
  ROOMWISE_RETURN_IF_ERROR(put(folder / "metadata.json", record3d_metadata(walk)));
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("rgb/{}.jpg", i), walk.jpeg(i)));
    ROOMWISE_RETURN_IF_ERROR(put(folder / fmt::format("depth/{}.exr", i), made::exr_file(depth)));
  }
  return folder;
}

}  // namespace

Expected<fs::path> write_as_kind(std::string_view kind, const fs::path& walk,
                                 const fs::path& folder) {
  static const std::map<std::string_view,
                        Expected<fs::path> (*)(const SourceWalk&, const fs::path&)>
      kWriters{{"TUM folder", &write_tum},
               {"3D Scanner App, All Data", &write_scanner_app},
               {"Stray Scanner", &write_stray_scanner},
               {"Polycam, raw data", &write_polycam},
               {"ARKitScenes", &write_arkitscenes},
               {"7-Scenes", &write_seven_scenes},
               {"MCAP", &write_mcap},
               {"ROS 1 bag, RealSense", &write_bag},
               {"ScanNet .sens", &write_sens},
               {"Record3D .r3d", &write_record3d},
               {"Record3D, EXR and JPG", &write_record3d_exr}};
  const auto writer = kWriters.find(kind);
  if (writer == kWriters.end()) return fail("nobody writes recordings of the kind {}", kind);
  ROOMWISE_TRY(const SourceWalk read, read_source_walk(walk));
  return writer->second(read, folder);
}

}  // namespace roomwise::testing
