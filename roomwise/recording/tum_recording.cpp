#include "roomwise/recording/tum_recording.h"

#include <algorithm>

#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/metadata.h"
#include "roomwise/recording/camera_file.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/inertial_file.h"
#include "roomwise/recording/odometry_file.h"
#include "roomwise/recording/personal_files.h"

namespace roomwise::recording {
namespace {

constexpr const char* kColorList = "rgb.txt";
constexpr const char* kDepthList = "depth.txt";
constexpr const char* kCameraFile = "camera.txt";
constexpr const char* kOdometryFile = "odometry.txt";
constexpr std::string_view kExample = "1305031229.528748 rgb/1305031229.528748.png";

struct ListedImage {
  TimestampNs timestamp_ns = 0;
  std::filesystem::path file;  // relative to the folder
};

Expected<ListedImage> parse_listed_image(const DataLine& line) {
  if (line.words.size() != 2) {
    return fail("{} words, expected a time stamp and a file such as {}", line.words.size(),
                kExample);
  }
  ListedImage image;
  ROOMWISE_TRY(image.timestamp_ns, parse_timestamp(line.words[0]));
  image.file = line.words[1];
  const bool goes_up = std::ranges::find(image.file, "..") != image.file.end();
  if (image.file.is_absolute() || goes_up) {
    return fail("'{}' lies outside the recording; give a file inside its folder", line.words[1]);
  }
  return image;
}

Expected<geometry::PinholeCamera> camera_of(const std::filesystem::path& folder,
                                            const RecordingOptions& options) {
  if (options.camera) return *options.camera;
  const auto file = folder / kCameraFile;
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) return read_camera(file);
  return fail(
      "{}: has no {}, so its camera is unknown; give --camera fr1|fr2|fr3|kinect-v1|xtion or the "
      "path of a camera file",
      folder.string(), kCameraFile);
}

std::string span_of(const ImageList& list) {
  return fmt::format("{} to {} s", format_timestamp(list.timestamps_ns().front()),
                     format_timestamp(list.timestamps_ns().back()));
}

std::vector<RecordedPicture> pictures_of(const ImageList& colors,
                                         const std::vector<Association>& associations) {
  std::vector<RecordedPicture> pictures;
  for (const TimestampNs timestamp_ns : colors.timestamps_ns()) {
    pictures.push_back({pictures.size(), timestamp_ns, false});
  }
  for (const Association& pair : associations) pictures[pair.first].has_depth = true;
  return pictures;
}

}  // namespace

Expected<ImageList> ImageList::open(const std::filesystem::path& folder,
                                    const std::filesystem::path& list_name) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    return fail("{}: is no folder; give the folder of a recording, with {} and {}", folder.string(),
                kColorList, kDepthList);
  }
  ImageList list;
  list.list_path_ = folder / list_name;
  if (!std::filesystem::exists(list.list_path_, ignored)) {
    return fail("{}: is missing; a recording is a folder with {} and {}", list.list_path_.string(),
                kColorList, kDepthList);
  }
  ROOMWISE_TRY(const std::string text, read_text_file(list.list_path_));
  for (const DataLine& line : data_lines(text)) {
    const std::string place = fmt::format("{}:{}", list.list_path_.string(), line.number);
    auto image = parse_listed_image(line);
    const bool torn = !line.complete &&
                      (!image || !std::filesystem::is_regular_file(folder / image->file, ignored));
    if (torn) break;
    if (!image) return Unexpected(std::move(image).error().with_context(place));
    if (list.size() > 0 && image->timestamp_ns <= list.timestamps_ns_.back()) {
      return fail("{}: the time {} does not increase; sort the lines by time, each time once",
                  place, line.words[0]);
    }
    list.timestamps_ns_.push_back(image->timestamp_ns);
    list.paths_.push_back(folder / image->file);
    list.lines_.push_back(line.number);
  }
  if (list.size() == 0) {
    return fail("{}: lists no image; expected lines such as {}", list.list_path_.string(),
                kExample);
  }
  return list;
}

std::string ImageList::place(std::size_t entry) const {
  return fmt::format("{}:{}", list_path_.string(), lines_[entry]);
}

Expected<Bytes> ImageList::read(std::size_t entry) const {
  auto bytes = read_file(path(entry));
  if (!bytes) {
    return fail("{}: {}; restore the image or take its line out of the list", place(entry),
                bytes.error().message);
  }
  return bytes;
}

Expected<image::ColorImage> ImageList::read_color(std::size_t entry) const {
  ROOMWISE_TRY(const Bytes bytes, read(entry));
  return in_context(describe(entry), image::decode_color(bytes));
}

std::string ImageList::describe(std::size_t entry) const {
  return fmt::format("{}: {}", place(entry), path(entry).string());
}

TumRecording::TumRecording(RecordingContents contents, ImageList colors, ImageList depths,
                           std::vector<Association> associations)
    : Recording(std::move(contents)),
      colors_(std::move(colors)),
      depths_(std::move(depths)),
      associations_(std::move(associations)) {}

bool TumRecording::recognises(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(folder / kColorList, ignored) &&
         std::filesystem::is_regular_file(folder / kDepthList, ignored);
}

Expected<std::unique_ptr<TumRecording>> TumRecording::open(const std::filesystem::path& folder,
                                                           const RecordingOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(ImageList colors, ImageList::open(folder, kColorList));
  ROOMWISE_TRY(ImageList depths, ImageList::open(folder, kDepthList));
  ROOMWISE_TRY(const geometry::PinholeCamera camera, camera_of(folder, options));
  auto associations =
      associate(colors.timestamps_ns(), depths.timestamps_ns(), options.tolerance_ns);
  if (associations.empty()) {
    return fail(
        "{}: no image of {} ({}) has one of {} ({}) within {} s; the lists must belong to one "
        "recording",
        folder.string(), kColorList, span_of(colors), kDepthList, span_of(depths),
        static_cast<double>(options.tolerance_ns) * kSecondsPerNs);
  }
  RecordingContents contents;
  contents.kind = "TUM folder";
  contents.info.name = recording_name(folder);
  contents.info.camera = camera;
  contents.info.personal_data =
      personal_data_of_some(colors.size(), [&](std::size_t i) { return colors.read(i); });
  contents.pictures = pictures_of(colors, associations);
  std::error_code ignored;
  if (std::filesystem::exists(folder / kOdometryFile, ignored)) {
    ROOMWISE_TRY(Odometry odometry, read_odometry(folder / kOdometryFile));
    contents.device_poses = std::move(odometry.poses);
    contents.device_up = odometry.up;
    contents.poses_are_device_motion = true;
  } else {
    contents.inertial = read_inertial(folder, contents.notes);
  }
  return std::unique_ptr<TumRecording>(new TumRecording(
      std::move(contents), std::move(colors), std::move(depths), std::move(associations)));
}

std::string TumRecording::describe(const RecordedPicture& picture) const {
  return colors_.path(picture.index).string();
}

Expected<image::ColorImage> TumRecording::read_picture(const RecordedPicture& picture) const {
  return colors_.read_color(picture.index);
}

Expected<Bytes> TumRecording::read_picture_file(const RecordedPicture& picture) const {
  ROOMWISE_TRY(const Bytes bytes, colors_.read(picture.index));
  auto bare = image::is_webp(bytes) ? std::nullopt : image::without_metadata(bytes);
  if (bare) return *std::move(bare);
  ROOMWISE_TRY(const image::ColorImage color, read_picture(picture));
  return image::encode_png(color);
}

Expected<image::RgbdFrame> TumRecording::read_frame(const RecordedPicture& picture) const {
  const auto association =
      std::ranges::lower_bound(associations_, picture.index, {}, &Association::first);
  const auto [color_entry, depth_entry] = *association;
  image::RgbdFrame frame;
  frame.index = color_entry;
  frame.timestamp_ns = colors_.timestamps_ns()[color_entry];
  ROOMWISE_TRY(frame.encoded_color, colors_.read(color_entry));
  ROOMWISE_TRY(frame.encoded_depth, depths_.read(depth_entry));

  ROOMWISE_TRY(auto color,
               in_context(colors_.describe(color_entry), image::decode_color(frame.encoded_color)));
  ROOMWISE_TRY(auto depth,
               in_context(depths_.describe(depth_entry), image::decode_depth(frame.encoded_depth)));
  if (color.width() != info().camera.width || color.height() != info().camera.height) {
    return fail("{}: has {}x{} pixels, the camera {}x{}; give the camera that took it",
                colors_.describe(color_entry), color.width(), color.height(), info().camera.width,
                info().camera.height);
  }
  if (depth.width() != color.width() || depth.height() != color.height()) {
    return fail("{}: has {}x{} pixels, its colour image {}x{}; depth must be registered to colour",
                depths_.describe(depth_entry), depth.width(), depth.height(), color.width(),
                color.height());
  }
  frame.color = std::move(color);
  frame.depth = std::move(depth);
  // Whoever sends or stores them says no more than what is seen. Frames are kept as JPEG or PNG.
  frame.encoded_color = image::is_webp(frame.encoded_color) ? Bytes() : image::color_file(frame);
  frame.encoded_depth = image::depth_file(frame);
  return frame;
}

}  // namespace roomwise::recording
