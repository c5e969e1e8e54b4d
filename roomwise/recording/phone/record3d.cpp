#include "roomwise/recording/phone/record3d.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/json_file.h"
#include "roomwise/recording/phone/longest_rise.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/phone/record3d_files.h"
#include "roomwise/recording/phone/zip_file.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using Json = nlohmann::json;

constexpr int kMaxRecord3dSide_px = 640;
constexpr int kMaxDepthSide = 4096;

struct Record3dFrame {
  TimestampNs timestamp_ns = 0;
  PinholeCamera camera;
  std::optional<geometry::RigidTransform> world_from_camera;
};

struct Record3dFacts {
  int depth_width = 0, depth_height = 0;
  std::map<std::size_t, Record3dFrame> frames;  // that have a picture, by their numbers
  std::vector<DamagedFrame> damaged;
  std::vector<std::string> notes;
  image::PersonalData personal_data;
};

Expected<int> side_of(const Json& json, const char* key, int max) {
  ROOMWISE_TRY(const double number, number_of(json, key));
  if (number < 1 || number > max || number != std::floor(number)) {
    return fail("'{}' = {} is no size of a picture", key, number);
  }
  return static_cast<int>(number);
}

const Json* list_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_array() && !found->empty() ? &*found : nullptr;
}

std::optional<std::vector<double>> numbers_from(const Json& list, std::size_t count) {
  if (!list.is_array() || list.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& one : list) {
    if (!one.is_number() || !std::isfinite(one.get<double>())) return std::nullopt;
    numbers.push_back(one.get<double>());
  }
  return numbers;
}

// fx, fy, cx, cy of each frame; older versions have the first one's alone, column after column.
Expected<PinholeCamera> camera_of_frame(const Json& json, std::size_t frame, PinholeCamera camera) {
  const Json* all = list_in(json, "perFrameIntrinsicCoeffs");
  if (all != nullptr) {
    const auto numbers = frame < all->size() ? numbers_from((*all)[frame], 4) : std::nullopt;
    if (!numbers) return fail("perFrameIntrinsicCoeffs has no four numbers of frame {}", frame);
    std::tie(camera.fx, camera.fy, camera.cx, camera.cy) =
        std::tuple((*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]);
  } else {
    ROOMWISE_TRY(const auto k, numbers_of(json, "K", 9));
    std::tie(camera.fx, camera.fy, camera.cx, camera.cy) = std::tuple(k[0], k[4], k[6], k[7]);
  }
  if (auto valid = camera.validate(); !valid) return Unexpected(std::move(valid).error());
  return camera;
}

// qx, qy, qz, qw, px, py, pz, in the axes of ARKit: x right, y up, z back.
Expected<geometry::RigidTransform> pose_of_frame(const Json& poses, std::size_t frame) {
  const auto numbers = frame < poses.size() ? numbers_from(poses[frame], 7) : std::nullopt;
  if (!numbers) return fail("poses has no seven numbers of frame {}", frame);
  const auto& n = *numbers;
  const Eigen::Quaterniond rotation(n[3], n[0], n[1], n[2]);
  constexpr double kRounding = 0.01;
  if (!(std::abs(rotation.norm() - 1) < kRounding)) {
    return fail("the quaternion of frame {} has not the length 1", frame);
  }
  const Eigen::Quaterniond arkit_from_camera(0, 1, 0, 0);  // half a turn about x
  return geometry::RigidTransform{rotation.normalized() * arkit_from_camera, {n[4], n[5], n[6]}};
}

Expected<TimestampNs> time_of_frame(const Json& json, std::size_t frame) {
  if (const Json* times = list_in(json, "frameTimestamps")) {
    if (frame >= times->size() || !(*times)[frame].is_number()) {
      return fail("frameTimestamps has no number of frame {}", frame);
    }
    return timestamp_of((*times)[frame].get<double>());
  }
  ROOMWISE_TRY(const double fps, number_of(json, "fps"));
  if (!(fps >= 0.1 && fps <= 1000)) return fail("'fps' = {} is no number of frames a second", fps);
  return timestamp_of(static_cast<double>(frame) / fps);
}

// How many frames there should be; 0 where that is not said.
std::size_t frames_listed(const Json& json) {
  std::size_t frames = 0;
  for (const char* key : {"frameTimestamps", "poses"}) {
    if (const Json* list = list_in(json, key)) frames = std::max(frames, list->size());
  }
  return frames;
}

Expected<Record3dFrame> frame_from(const Json& json, std::size_t i, const PinholeCamera& size) {
  Record3dFrame frame;
  ROOMWISE_TRY(frame.timestamp_ns, time_of_frame(json, i));
  ROOMWISE_TRY(frame.camera, camera_of_frame(json, i, size));
  if (const Json* poses = list_in(json, "poses")) {
    ROOMWISE_TRY(frame.world_from_camera, pose_of_frame(*poses, i));
  }
  return frame;
}

void leave_out_wrong_times(Record3dFacts& facts, const std::string& file) {
  keep_longest_rise(
      facts.frames, [](const auto& frame) { return frame.second.timestamp_ns; },
      [&](const auto& frame) {
        facts.damaged.push_back(
            {frame.first, fmt::format("{}: the time of frame {} does not fit those of the others",
                                      file, frame.first)});
      });
  std::ranges::sort(facts.damaged, {}, &DamagedFrame::index);
}

Expected<Record3dFacts> facts_from(const Json& json, const Record3dFiles& files) {
  Record3dFacts facts;
  PinholeCamera size;
  ROOMWISE_TRY(size.width, side_of(json, "w", 65'535));
  ROOMWISE_TRY(size.height, side_of(json, "h", 65'535));
  ROOMWISE_TRY(facts.depth_width, side_of(json, "dw", kMaxDepthSide));
  ROOMWISE_TRY(facts.depth_height, side_of(json, "dh", kMaxDepthSide));
  if (!has_shape_of(size, facts.depth_width, facts.depth_height)) {
    return fail("depth of {}x{} pixels is of another shape than pictures of {}x{}",
                facts.depth_width, facts.depth_height, size.width, size.height);
  }
  const std::size_t listed = frames_listed(json);
  std::size_t lacking = 0;
  for (std::size_t i = 0; i < listed || (listed == 0 && files.has_color(i)); ++i) {
    if (!files.has_color(i)) {  // a copy may lack some
      ++lacking;
      continue;
    }
    auto frame = frame_from(json, i, size);
    if (frame) {
      facts.frames.emplace(i, *std::move(frame));
    } else {
      facts.damaged.push_back(
          {i, fmt::format("{}: {}", files.name_of_metadata(), frame.error().message)});
    }
  }
  leave_out_wrong_times(facts, files.name_of_metadata());
  if (lacking > 0) {
    facts.notes.push_back(
        fmt::format("{} of {} frames have no picture; were all copied?", lacking, listed));
  }
  facts.personal_data = personal_data_of_json(json);
  return facts;
}

Expected<Record3dFacts> read_facts(const Record3dFiles& files) {
  const std::string name = files.name_of_metadata();
  ROOMWISE_TRY(const Bytes bytes, files.read_metadata());
  const Json json = Json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!json.is_object()) return fail("{}: is no JSON object", name);
  return in_context(name, facts_from(json, files));
}

// The app turns a portrait and its depth a quarter clockwise, so that what was the first row, on
// which ARKit's measurements begin, is the last column.
PinholeCamera record3d_depth_camera(const PinholeCamera& camera, int width, int height) {
  PinholeCamera depth = depth_camera(camera, width, height);
  const double step = 1.0 * camera.width / width;
  if (camera.height > camera.width) depth.cx = (camera.cx - (step - 1)) / step;
  return depth;
}

class Record3dRecording final : public Recording {
 public:
  Record3dRecording(RecordingContents contents, std::unique_ptr<Record3dFiles> files,
                    Record3dFacts facts)
      : Recording(std::move(contents)), files_(std::move(files)), facts_(std::move(facts)) {}

  [[nodiscard]] std::string describe(const RecordedPicture& picture) const override {
    return files_->name_of_color(picture.index);
  }

 private:
  [[nodiscard]] Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const override {
    ROOMWISE_TRY(const Bytes bytes, files_->read_color(picture.index));
    ROOMWISE_TRY(const auto color, in_context(describe(picture), image::decode_color(bytes)));
    const PinholeCamera& camera = facts_.frames.at(picture.index).camera;
    if (color.width() != camera.width || color.height() != camera.height) {
      return fail("{}: has {}x{} pixels, metadata says {}x{}", describe(picture), color.width(),
                  color.height(), camera.width, camera.height);
    }
    return as_seen_by(color, camera, info().camera);
  }

  [[nodiscard]] Expected<image::DepthImage> read_depth(const RecordedPicture& picture) const {
    ROOMWISE_TRY(const auto depth_m,
                 files_->read_depth_m(picture.index, facts_.depth_width, facts_.depth_height));
    image::DepthImage depth(facts_.depth_width, facts_.depth_height);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const float mm = 1000 * depth_m.pixels()[i];
      // Numbers that are none fail both.
      if (mm >= 1 && mm < 65'535) depth.pixels()[i] = static_cast<std::uint16_t>(std::lround(mm));
    }
    const PinholeCamera& camera = facts_.frames.at(picture.index).camera;
    return as_seen_by(depth, record3d_depth_camera(camera, depth.width(), depth.height()),
                      info().camera);
  }

  [[nodiscard]] Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const override {
    image::RgbdFrame frame;
    frame.index = picture.index;
    frame.timestamp_ns = picture.timestamp_ns;
    ROOMWISE_TRY(frame.color, read_picture(picture));
    ROOMWISE_TRY(frame.depth, read_depth(picture));
    return frame;
  }

  std::unique_ptr<Record3dFiles> files_;
  Record3dFacts facts_;
};

Expected<std::unique_ptr<Recording>> open_record3d_files(std::unique_ptr<Record3dFiles> files,
                                                         const RecordingOptions& options) {
  const std::string path = files->path().string();
  ROOMWISE_TRY(Record3dFacts facts, read_facts(*files));
  if (facts.frames.empty()) return no_whole_frame(path, facts.damaged);
  RecordingContents contents;
  contents.damaged = facts.damaged;
  contents.notes = facts.notes;
  contents.kind = files->kind();
  contents.info.name = recording_name(files->path());
  contents.poses_are_device_motion = true;
  contents.device_up = kArkitUp;
  std::vector<PinholeCamera> cameras;
  for (const auto& [i, frame] : facts.frames) {
    cameras.push_back(frame.camera);
    contents.pictures.push_back({i, frame.timestamp_ns, files->has_depth(i)});
    if (frame.world_from_camera) {
      contents.device_poses.push_back({frame.timestamp_ns, *frame.world_from_camera});
    }
  }
  if (std::ranges::none_of(contents.pictures, &RecordedPicture::has_depth)) {
    return fail("{}: no picture has a depth image", path);
  }
  contents.info.personal_data = facts.personal_data;
  contents.info.personal_data |= personal_data_of_some(
      contents.pictures.size(),
      [&](std::size_t i) { return files->read_color(contents.pictures[i].index); });
  contents.info.camera = common_camera(cameras, kMaxRecord3dSide_px);
  if (options.camera && *options.camera != contents.info.camera) {
    return fail("{}: says itself which camera took it; leave the other camera out", path);
  }
  return std::unique_ptr<Recording>(
      new Record3dRecording(std::move(contents), std::move(files), std::move(facts)));
}

}  // namespace

bool is_record3d_file(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  const auto zip = ZipFile::open(path);
  // One that names files elsewhere is said to be so when it is opened.
  if (!zip) return path.extension() == ".r3d";
  return zip->contains("metadata") && zip->contains("rgbd/0.jpg");
}

Expected<std::unique_ptr<Recording>> open_record3d(const std::filesystem::path& path,
                                                   const RecordingOptions& options) {
  ROOMWISE_TRY(auto files, open_record3d_zip(path));
  return open_record3d_files(std::move(files), options);
}

bool is_record3d_exr_folder(const std::filesystem::path& folder) {
  return !find_record3d_folder(folder).empty();
}

Expected<std::unique_ptr<Recording>> open_record3d_exr_folder(const std::filesystem::path& folder,
                                                              const RecordingOptions& options) {
  if (!is_record3d_exr_folder(folder)) {
    return fail("{}: has no metadata.json, rgb/0.jpg and depth/", folder.string());
  }
  return open_record3d_files(open_record3d_exr(folder), options);
}

}  // namespace roomwise::recording
