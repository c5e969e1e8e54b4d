#include "roomwise/recording/robot/robot_recording.h"

#include <algorithm>
#include <array>

#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/association.h"
#include "roomwise/recording/messages/mcap_file.h"
#include "roomwise/recording/messages/ros1_bag.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/robot/depth_registration.h"
#include "roomwise/recording/robot/device_poses.h"
#include "roomwise/recording/robot/streams.h"
#include "roomwise/recording/robot/working_camera.h"

namespace roomwise::recording {
namespace {

// The messages of a stream in the order of time, each time once.
struct TimedMessages {
  std::vector<const MessagePlace*> messages;
  std::vector<TimestampNs> times;
};

// Cameras whose driver sets no time leave zeros.
bool has_header_times(const std::vector<MessagePlace>& messages) {
  return messages.size() < 2 || (messages.front().timestamp_ns > 0 &&
                                 messages.front().timestamp_ns != messages.back().timestamp_ns);
}

TimedMessages timed(const std::vector<MessagePlace>& messages, bool by_header) {
  std::vector<std::pair<TimestampNs, const MessagePlace*>> all;
  for (const MessagePlace& one : messages) {
    all.emplace_back(by_header ? one.timestamp_ns : one.logged_ns, &one);
  }
  std::ranges::stable_sort(all, {}, &std::pair<TimestampNs, const MessagePlace*>::first);
  TimedMessages result;
  for (const auto& [time, message] : all) {
    if (!result.times.empty() && time <= result.times.back()) continue;
    result.times.push_back(time);
    result.messages.push_back(message);
  }
  return result;
}

class RobotRecording final : public Recording {
 public:
  RobotRecording(RecordingContents contents, std::shared_ptr<const MessageLog> log, StreamPair pair,
                 const WorkingCamera& camera, TimedMessages colors,
                 std::vector<const MessagePlace*> depths)
      : Recording(std::move(contents)),
        log_(std::move(log)),
        pair_(std::move(pair)),
        camera_(camera),
        colors_(std::move(colors)),
        depths_(std::move(depths)) {
    if (!pair_.is_registered) {
      registration_.emplace(*pair_.depth.camera, camera.working, pair_.color_from_depth);
    }
  }

  [[nodiscard]] std::string describe(const RecordedPicture& picture) const override {
    return fmt::format("{}: {} at {} s", log_->path().string(), pair_.color.topic,
                       format_timestamp(picture.timestamp_ns));
  }

 private:
  template <typename Value>
  [[nodiscard]] Expected<Value> named(Expected<Value> value, const ImageStream& stream,
                                      const MessagePlace& message) const {
    if (value) return value;
    return Unexpected(std::move(value).error().with_context(
        fmt::format("{}: {} at {} s", log_->path().string(), stream.topic,
                    format_timestamp(message.timestamp_ns))));
  }

  // A picture, and the file that it came in, if any.
  template <typename Picture>
  struct Decoded {
    Picture picture;
    Bytes file;
  };
  [[nodiscard]] Expected<Decoded<image::ColorImage>> decode_color(
      const MessagePlace& message) const {
    const Channel& channel = log_->channels()[pair_.color.channel];
    ROOMWISE_TRY(const Bytes bytes, log_->read(message));
    Decoded<image::ColorImage> decoded;
    if (pair_.color.is_compressed) {
      ROOMWISE_TRY(CompressedImageMessage one, decode_compressed_image(channel, bytes));
      ROOMWISE_TRY(decoded.picture, color_of(one));
      // Frames are kept as JPEG or PNG.
      if (!image::is_webp(one.data)) decoded.file = std::move(one.data);
    } else {
      ROOMWISE_TRY(const ImageMessage one, decode_image(channel, bytes));
      ROOMWISE_TRY(decoded.picture, color_of(one));
    }
    ROOMWISE_RETURN_IF_ERROR(check_size(pair_.color, decoded.picture));
    if (camera_.is_recorded_size()) return decoded;
    return Decoded<image::ColorImage>{
        as_seen_by(decoded.picture, camera_.recorded, camera_.working), {}};
  }

  [[nodiscard]] Expected<Decoded<image::DepthImage>> decode_depth(
      const MessagePlace& message) const {
    const Channel& channel = log_->channels()[pair_.depth.channel];
    ROOMWISE_TRY(const Bytes bytes, log_->read(message));
    Decoded<image::DepthImage> decoded;
    if (pair_.depth.is_compressed) {
      ROOMWISE_TRY(const CompressedImageMessage one, decode_compressed_image(channel, bytes));
      ROOMWISE_TRY(decoded.picture, depth_of(one));
      const auto png = depth_png_of(one);
      decoded.file.assign(png.begin(), png.end());
    } else {
      ROOMWISE_TRY(const ImageMessage one, decode_image(channel, bytes));
      ROOMWISE_TRY(decoded.picture, depth_of(one));
    }
    ROOMWISE_RETURN_IF_ERROR(check_size(pair_.depth, decoded.picture));
    return in_color(std::move(decoded));
  }

  // On the colour picture, and of its size.
  [[nodiscard]] Decoded<image::DepthImage> in_color(Decoded<image::DepthImage> decoded) const {
    if (registration_) return {registration_->apply(decoded.picture), {}};
    if (camera_.is_recorded_size()) return decoded;
    return {as_seen_by(decoded.picture, camera_.recorded, camera_.working), {}};
  }

  template <typename Picture>
  static Expected<void> check_size(const ImageStream& stream, const Picture& picture) {
    if (picture.width() == stream.width && picture.height() == stream.height) return {};
    return fail("has {}x{} pixels, the others {}x{}", picture.width(), picture.height(),
                stream.width, stream.height);
  }

  [[nodiscard]] Expected<image::RgbdFrame> read_frame(
      const RecordedPicture& picture) const override {
    const MessagePlace& color = *colors_.messages[picture.index];
    const MessagePlace& depth = *depths_[picture.index];
    ROOMWISE_TRY(auto decoded_color, named(decode_color(color), pair_.color, color));
    ROOMWISE_TRY(auto decoded_depth, named(decode_depth(depth), pair_.depth, depth));
    return image::RgbdFrame{picture.index,
                            picture.timestamp_ns,
                            std::move(decoded_color.picture),
                            std::move(decoded_depth.picture),
                            std::move(decoded_color.file),
                            std::move(decoded_depth.file)};
  }

  [[nodiscard]] Expected<image::ColorImage> read_picture(
      const RecordedPicture& picture) const override {
    const MessagePlace& color = *colors_.messages[picture.index];
    ROOMWISE_TRY(auto decoded, named(decode_color(color), pair_.color, color));
    return std::move(decoded.picture);
  }

  std::shared_ptr<const MessageLog> log_;
  StreamPair pair_;
  WorkingCamera camera_;  // of colour
  TimedMessages colors_;
  std::vector<const MessagePlace*> depths_;  // of each colour image; null where it has none
  std::optional<DepthRegistration> registration_;
};

// What was passed over may be why nothing fits.
Expected<StreamPair> with_notes(Expected<StreamPair> pair, const std::vector<std::string>& notes) {
  if (pair || notes.empty()) return pair;
  return fail("{}; {}", pair.error().message, fmt::join(notes, "; "));
}

bool tells_place(const Channel& channel) {
  return std::ranges::any_of(
      std::array{"NavSatFix", "GPSFix", "LocationFix", "GeoPoint"},
      [&](const char* type) { return channel.type_name.find(type) != std::string::npos; });
}

image::PersonalData personal_data_of(const MessageLog& log, const ImageStream& color,
                                     const TimedMessages& colors) {
  image::PersonalData facts;
  if (color.is_compressed) {
    facts = personal_data_of_some(colors.messages.size(), [&](std::size_t i) -> Expected<Bytes> {
      ROOMWISE_TRY(const Bytes bytes, log.read(*colors.messages[i]));
      ROOMWISE_TRY(CompressedImageMessage one,
                   decode_compressed_image(log.channels()[color.channel], bytes));
      return std::move(one.data);
    });
  }
  facts.place = facts.place || std::ranges::any_of(log.channels(), tells_place);
  return facts;
}

Expected<std::unique_ptr<Recording>> open_log(std::string kind, MessageLog whole_log,
                                              const RecordingOptions& options) {
  const auto log = std::make_shared<const MessageLog>(std::move(whole_log));
  RecordingContents contents;
  contents.kind = std::move(kind);
  contents.info.name = recording_name(log->path());
  contents.notes = log->notes();
  const TransformTree tree = read_transforms(*log, contents.notes);
  const auto streams = find_image_streams(*log, contents.notes);
  ROOMWISE_TRY(StreamPair pair,
               with_notes(choose_streams(streams, tree, contents.notes), contents.notes));
  pair.color.camera->depth_units_per_metre = 1 / pair.depth.depth_unit_m;
  ROOMWISE_TRY(const WorkingCamera camera, working_camera(*pair.color.camera, options.camera));
  contents.info.camera = camera.working;

  const auto& color_messages = log->messages(pair.color.channel);
  const auto& depth_messages = log->messages(pair.depth.channel);
  const bool by_header = has_header_times(color_messages) && has_header_times(depth_messages);
  if (!by_header) contents.notes.emplace_back("images have no times: those of recording are taken");
  TimedMessages colors = timed(color_messages, by_header);
  const TimedMessages depths = timed(depth_messages, by_header);
  std::vector<const MessagePlace*> depth_of_color(colors.times.size());
  for (const auto& [color, depth] : associate(colors.times, depths.times, options.tolerance_ns)) {
    depth_of_color[color] = depths.messages[depth];
  }
  for (std::size_t i = 0; i < colors.times.size(); ++i) {
    contents.pictures.push_back({i, colors.times[i], depth_of_color[i] != nullptr});
  }
  if (std::ranges::none_of(contents.pictures, &RecordedPicture::has_depth)) {
    return fail("no image of {} has one of {} within {} s", pair.color.topic, pair.depth.topic,
                static_cast<double>(options.tolerance_ns) * kSecondsPerNs);
  }
  contents.info.personal_data = personal_data_of(*log, pair.color, colors);
  DevicePoses found = find_device_poses(*log, tree, pair.color.frame, colors.times);
  contents.poses_are_device_motion = found.are_odometry;
  contents.device_poses = std::move(found.poses);
  if (!contents.poses_are_device_motion || contents.device_poses.empty())
    contents.inertial = find_inertial(*log, tree, pair.color.frame, contents.notes);
  return std::unique_ptr<Recording>(new RobotRecording(std::move(contents), log, std::move(pair),
                                                       camera, std::move(colors),
                                                       std::move(depth_of_color)));
}

Expected<std::unique_ptr<Recording>> open_named(std::string kind, Expected<MessageLog> log,
                                                const RecordingOptions& options) {
  if (!log) return Unexpected(std::move(log).error());
  const std::string path = log->path().string();
  return in_context(path, open_log(std::move(kind), *std::move(log), options));
}

Bytes first_bytes_of(const std::filesystem::path& path) {
  constexpr std::uint64_t kEnough = 16;
  const auto file = RandomAccessFile::open(path);
  if (!file) return {};
  return file->read(0, std::min(kEnough, file->size())).value_or(Bytes());
}

}  // namespace

bool is_mcap_file(const std::filesystem::path& path) {
  return is_mcap(first_bytes_of(path));
}

bool is_ros1_bag_file(const std::filesystem::path& path) {
  return is_ros1_bag(first_bytes_of(path));
}

Expected<std::unique_ptr<Recording>> open_mcap_recording(const std::filesystem::path& path,
                                                         const RecordingOptions& options) {
  return open_named("MCAP", read_mcap(path), options);
}

Expected<std::unique_ptr<Recording>> open_ros1_bag_recording(const std::filesystem::path& path,
                                                             const RecordingOptions& options) {
  return open_named("ROS 1 bag", read_ros1_bag(path), options);
}

}  // namespace roomwise::recording
