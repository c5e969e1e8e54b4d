#include "roomwise/recording/sens/sens_recording.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/base/byte_reader.h"
#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/bytes/random_access_file.h"
#include "roomwise/recording/bytes/unpack.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/longest_rise.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/robot/working_camera.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using Matrix4 = std::array<float, 16>;  // row after row

constexpr std::uint32_t kSensVersion = 4;
constexpr std::uint64_t kMaxSensName = 4096;
constexpr std::uint64_t kSensHeadBytes = 4 * 64 + 2 * 4 + 4 * 4 + 4 + 8;  // behind the name
constexpr std::uint64_t kSensFrameHead = 64 + 4 * 8;
constexpr std::uint32_t kMaxSensSide = 65'535;
constexpr TimestampNs kMicrosecond = 1000;
// ScanNet's own files of some scans have no times; the camera takes 30 pictures a second.
constexpr TimestampNs kSensPeriod = 1'000'000'000 / 30;

enum SensColor : std::int32_t { kRawColor = 0, kPngColor = 1, kJpegColor = 2 };
enum SensDepth : std::int32_t { kRawDepth = 0, kZlibDepth = 1 };

struct SensHead {
  PinholeCamera color, depth;
  std::int32_t color_packing = 0, depth_packing = 0;
  std::uint64_t frame_count = 0;  // as claimed
  std::uint64_t first_frame = 0;  // its place in the file
};

struct SensFrame {
  std::uint64_t offset = 0;  // of colour; depth lies behind it
  std::uint64_t color_size = 0, depth_size = 0;
  TimestampNs timestamp_ns = 0;
  Matrix4 world_from_camera{};
};

Matrix4 read_matrix(ByteReader& reader) {
  Matrix4 matrix{};
  for (float& number : matrix) number = reader.number<float>();
  return matrix;
}

bool is_identity(const Matrix4& matrix) {
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    if (!(std::abs(matrix[i] - (i % 5 == 0 ? 1.0F : 0.0F)) < 1e-6F)) return false;
  }
  return true;
}

PinholeCamera camera_from(const Matrix4& k, std::uint32_t width, std::uint32_t height) {
  PinholeCamera camera;
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[5];
  camera.cy = k[6];
  camera.width = static_cast<int>(std::min(width, kMaxSensSide));
  camera.height = static_cast<int>(std::min(height, kMaxSensSide));
  return camera;
}

std::size_t pixels_of(const PinholeCamera& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

Expected<void> check(const SensHead& head) {
  if (head.color_packing < kRawColor || head.color_packing > kJpegColor) {
    return fail("its colour is packed in the way {}, which is not read; write it as JPEG",
                head.color_packing);
  }
  if (head.depth_packing != kRawDepth && head.depth_packing != kZlibDepth) {
    return fail("its depth is packed in the way {}, which is not read; write it with zlib",
                head.depth_packing);
  }
  for (const PinholeCamera* camera : {&head.color, &head.depth}) {
    if (auto valid = camera->validate(); !valid) {
      return Unexpected(std::move(valid).error().with_context("its camera"));
    }
    if (pixels_of(*camera) > static_cast<std::size_t>(image::kMaxPixels)) {
      return fail("its camera claims {}x{} pixels", camera->width, camera->height);
    }
  }
  return {};
}

Expected<std::uint64_t> read_version_and_name(const RandomAccessFile& file) {
  ROOMWISE_TRY(const Bytes bytes, file.read(0, 12));
  ByteReader reader(bytes);
  const auto version = reader.number<std::uint32_t>();
  const auto name_size = reader.number<std::uint64_t>();
  if (version != kSensVersion || name_size > kMaxSensName) {
    return fail("{}: is of version {}; version {} is read", file.path().string(), version,
                kSensVersion);
  }
  return 12 + name_size;
}

Expected<SensHead> read_head(const RandomAccessFile& file) {
  ROOMWISE_TRY(const std::uint64_t begin, read_version_and_name(file));
  ROOMWISE_TRY(const Bytes bytes, file.read(begin, kSensHeadBytes));
  ByteReader reader(bytes);
  const Matrix4 color = read_matrix(reader), color_place = read_matrix(reader);
  const Matrix4 depth = read_matrix(reader), depth_place = read_matrix(reader);
  SensHead head;
  head.color_packing = reader.number<std::int32_t>();
  head.depth_packing = reader.number<std::int32_t>();
  std::array<std::uint32_t, 4> sides{};
  for (std::uint32_t& side : sides) side = reader.number<std::uint32_t>();
  head.color = camera_from(color, sides[0], sides[1]);
  head.depth = camera_from(depth, sides[2], sides[3]);
  head.color.depth_units_per_metre = head.depth.depth_units_per_metre = reader.number<float>();
  head.frame_count = reader.number<std::uint64_t>();
  head.first_frame = begin + kSensHeadBytes;
  if (auto fine = check(head); !fine) {
    return Unexpected(std::move(fine).error().with_context(file.path().string()));
  }
  if (!is_identity(color_place) || !is_identity(depth_place)) {
    return fail(
        "{}: its colour and depth cameras lie apart; register depth to colour (ScanNet's own files "
        "are)",
        file.path().string());
  }
  return head;
}

// The frames that are there in full.
Expected<std::vector<SensFrame>> read_frames(const RandomAccessFile& file, const SensHead& head) {
  std::vector<SensFrame> frames;
  std::uint64_t offset = head.first_frame;
  while (frames.size() < head.frame_count && file.holds(offset, kSensFrameHead)) {
    ROOMWISE_TRY(const Bytes bytes, file.read(offset, kSensFrameHead));
    ByteReader reader(bytes);
    SensFrame frame;
    frame.world_from_camera = read_matrix(reader);
    const auto microseconds = reader.number<std::uint64_t>();
    reader.number<std::uint64_t>();  // the depth's time
    frame.timestamp_ns =
        static_cast<TimestampNs>(microseconds % (INT64_MAX / kMicrosecond)) * kMicrosecond;
    frame.color_size = reader.number<std::uint64_t>();
    frame.depth_size = reader.number<std::uint64_t>();
    frame.offset = offset + kSensFrameHead;
    const bool is_there = file.holds(frame.offset, frame.color_size) &&
                          file.holds(frame.offset + frame.color_size, frame.depth_size);
    if (!is_there) break;
    offset = frame.offset + frame.color_size + frame.depth_size;
    frames.push_back(frame);
  }
  return frames;
}

// Whether the time of each frame fits those of the others. Where most do not, all are given others.
std::vector<bool> give_times(std::vector<SensFrame>& frames, std::vector<std::string>& notes) {
  std::vector<TimestampNs> times;
  for (const SensFrame& frame : frames) times.push_back(frame.timestamp_ns);
  std::vector<bool> fits = in_longest_increasing_subsequence(times);
  if (2 * std::ranges::count(fits, true) > std::ssize(frames)) return fits;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].timestamp_ns = static_cast<TimestampNs>(i) * kSensPeriod;
  }
  notes.emplace_back("most frames have no time that fits the others': 30 a second are assumed");
  return std::vector<bool>(frames.size(), true);
}

std::optional<geometry::RigidTransform> pose_of(const Matrix4& matrix) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      rotation(static_cast<int>(row), static_cast<int>(column)) = matrix[4 * row + column];
    }
    translation[static_cast<int>(row)] = matrix[4 * row + 3];
  }
  const bool is_rotation = rotation.allFinite() && translation.allFinite() &&
                           (rotation * rotation.transpose()).isIdentity(1e-2) &&
                           rotation.determinant() > 0;
  if (!is_rotation) return std::nullopt;
  return geometry::RigidTransform::from_matrix(rotation, translation);
}

class SensRecording final : public Recording {
 public:
  SensRecording(RecordingContents contents, RandomAccessFile file, const SensHead& head,
                const WorkingCamera& camera, std::vector<SensFrame> frames)
      : Recording(std::move(contents)),
        file_(std::move(file)),
        head_(head),
        camera_(camera),
        frames_of_file_(std::move(frames)) {}

  [[nodiscard]] std::string describe(const RecordedPicture& picture) const override {
    return fmt::format("{}: frame {}", file_.path().string(), picture.index);
  }

 private:
  [[nodiscard]] Expected<image::ColorImage> decode(std::span<const std::uint8_t> bytes) const {
    if (head_.color_packing != kRawColor) return image::decode_color(bytes);
    const std::size_t expected = 3 * pixels_of(head_.color);
    if (bytes.size() != expected) {
      return fail("has {} bytes of colour, {}x{} pixels need {}", bytes.size(), head_.color.width,
                  head_.color.height, expected);
    }
    image::ColorImage color(head_.color.width, head_.color.height);
    for (std::size_t i = 0; i < color.pixels().size(); ++i) {
      color.pixels()[i] = {bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]};
    }
    return color;
  }

  [[nodiscard]] Expected<image::ColorImage> to_working_size(image::ColorImage color) const {
    if (color.width() != head_.color.width || color.height() != head_.color.height) {
      return fail("has {}x{} pixels, the file says {}x{}", color.width(), color.height(),
                  head_.color.width, head_.color.height);
    }
    return camera_.is_recorded_size() ? std::move(color)
                                      : as_seen_by(color, camera_.recorded, camera_.working);
  }

  [[nodiscard]] Expected<image::DepthImage> read_depth(const SensFrame& frame) const {
    ROOMWISE_TRY(const Bytes packed, file_.read(frame.offset + frame.color_size, frame.depth_size));
    const Packing packing = head_.depth_packing == kZlibDepth ? Packing::kZlib : Packing::kNone;
    ROOMWISE_TRY(const Bytes bytes, unpack(packing, packed, 2 * pixels_of(head_.depth)));
    image::DepthImage depth(head_.depth.width, head_.depth.height);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      depth.pixels()[i] = load<std::uint16_t>(bytes.data() + 2 * i);
    }
    return head_.depth == camera_.working ? std::move(depth)
                                          : as_seen_by(depth, head_.depth, camera_.working);
  }

  // Colour of the working size, and where that is the file's own the bytes that it came in.
  struct Color {
    image::ColorImage picture;
    Bytes encoded;
  };
  [[nodiscard]] Expected<Color> read_color_of(const SensFrame& frame) const {
    Color color;
    ROOMWISE_TRY(color.encoded, file_.read(frame.offset, frame.color_size));
    ROOMWISE_TRY(image::ColorImage decoded, decode(color.encoded));
    ROOMWISE_TRY(color.picture, to_working_size(std::move(decoded)));
    if (!camera_.is_recorded_size() || head_.color_packing == kRawColor) color.encoded.clear();
    return color;
  }

  template <typename Value>
  [[nodiscard]] Expected<Value> named(Expected<Value> value, const RecordedPicture& picture) const {
    if (value) return value;
    return Unexpected(std::move(value).error().with_context(describe(picture)));
  }

  [[nodiscard]] Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const override {
    const SensFrame& frame = frames_of_file_[picture.index];
    ROOMWISE_TRY(Color color, named(read_color_of(frame), picture));
    ROOMWISE_TRY(image::DepthImage depth, named(read_depth(frame), picture));
    return image::RgbdFrame{picture.index,    picture.timestamp_ns,     std::move(color.picture),
                            std::move(depth), std::move(color.encoded), {}};
  }

  [[nodiscard]] Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const override {
    ROOMWISE_TRY(Color color, named(read_color_of(frames_of_file_[picture.index]), picture));
    return std::move(color.picture);
  }

  RandomAccessFile file_;
  SensHead head_;
  WorkingCamera camera_;  // of colour
  std::vector<SensFrame> frames_of_file_;
};

}  // namespace

// The version alone is a number that other files begin with, too.
bool is_sens_file(const std::filesystem::path& path) {
  const auto file = RandomAccessFile::open(path);
  const auto begin = file ? read_version_and_name(*file) : Unexpected(file.error());
  const auto head =
      begin ? file->read(*begin + 4 * sizeof(Matrix4), 24) : Unexpected(begin.error());
  if (!head) return false;
  ByteReader reader(*head);
  const auto is_packing = [&] { return reader.number<std::uint32_t>() + 1 <= 3; };
  const auto is_side = [&] { return reader.number<std::uint32_t>() - 1 < kMaxSensSide; };
  return is_packing() && is_packing() && is_side() && is_side() && is_side() && is_side();
}

Expected<std::unique_ptr<Recording>> open_sens_recording(const std::filesystem::path& path,
                                                         const RecordingOptions& options) {
  ROOMWISE_TRY(RandomAccessFile file, RandomAccessFile::open(path));
  ROOMWISE_TRY(const SensHead head, read_head(file));
  ROOMWISE_TRY(const auto camera,
               in_context(path.string(), working_camera(head.color, options.camera)));
  ROOMWISE_TRY(std::vector<SensFrame> frames, read_frames(file, head));
  if (frames.empty()) return fail("{}: holds no whole frame", path.string());
  RecordingContents contents;
  contents.kind = "ScanNet .sens";
  contents.info.name = recording_name(path);
  contents.info.camera = camera.working;
  if (frames.size() < head.frame_count) {
    contents.notes.push_back(
        fmt::format("the file ends within frame {} of {}; those before are read", frames.size(),
                    head.frame_count));
  }
  const std::vector<bool> fits = give_times(frames, contents.notes);
  contents.info.personal_data = personal_data_of_some(frames.size(), [&](std::size_t i) {
    return file.read(frames[i].offset, frames[i].color_size);
  });
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!fits[i]) {
      contents.damaged.push_back(
          {i, fmt::format("{}: the time of frame {} does not fit those of the others",
                          path.string(), i)});
      continue;
    }
    contents.pictures.push_back({i, frames[i].timestamp_ns, true});
    const auto pose = pose_of(frames[i].world_from_camera);
    if (pose) contents.device_poses.push_back({frames[i].timestamp_ns, *pose});
  }
  return std::unique_ptr<Recording>(
      new SensRecording(std::move(contents), std::move(file), head, camera, std::move(frames)));
}

}  // namespace roomwise::recording
