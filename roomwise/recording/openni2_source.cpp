#include "roomwise/recording/openni2_source.h"

#include <OpenNI.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

namespace roomwise::recording {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kFramesPerSecond = 30;
constexpr TimestampNs kNsPerMicrosecond = 1000;
constexpr TimestampNs kHalfFramePeriodNs = 1'000'000'000 / kFramesPerSecond / 2;

// OpenNI's own words for the last failure, as a part of one line.
std::string openni_reason() {
  std::string reason = openni::OpenNI::getExtendedError();
  std::ranges::replace_if(
      reason, [](char c) { return c == '\n' || c == '\t' || c == '\r'; }, ' ');
  const std::size_t first = reason.find_first_not_of(' ');
  if (first == std::string::npos) return "no reason given";
  return reason.substr(first, reason.find_last_not_of(' ') - first + 1);
}

// Keeps OpenNI running while it lives; OpenNI counts how many do.
class Library {
 public:
  Library() : status_(openni::OpenNI::initialize()) {}
  ~Library() {
    if (started()) openni::OpenNI::shutdown();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  [[nodiscard]] bool started() const { return status_ == openni::STATUS_OK; }

 private:
  openni::Status status_;
};

// Frames of a stream that wait for their partners of the other one. Few are enough: the streams lag
// behind each other by at most a frame or two.
constexpr std::size_t kMaxWaiting = 4;

// One of the device's two streams.
struct Stream {
  const char* name;
  openni::SensorType sensor;
  openni::VideoStream stream{};
  std::deque<openni::VideoFrameRef> waiting{};  // in the order of time
  int frames_in_file = 0;                       // 0 for a camera
  int frames_passed = 0;                        // the file's frames up to the newest one read

  [[nodiscard]] bool at_end() const {
    return frames_in_file > 0 && frames_passed >= frames_in_file;
  }
};

TimestampNs timestamp_ns(const openni::VideoFrameRef& frame) {
  return static_cast<TimestampNs>(frame.getTimestamp()) * kNsPerMicrosecond;
}

// The device's way to give 640x480 at 30 frames a second in the first of the formats that it knows.
const openni::VideoMode* find_mode(const openni::SensorInfo& sensor,
                                   std::span<const openni::PixelFormat> formats) {
  const auto& modes = sensor.getSupportedVideoModes();
  for (const openni::PixelFormat format : formats) {
    for (int i = 0; i < modes.getSize(); ++i) {
      const openni::VideoMode& mode = modes[i];
      if (mode.getPixelFormat() == format && mode.getResolutionX() == kWidth &&
          mode.getResolutionY() == kHeight && mode.getFps() == kFramesPerSecond) {
        return &mode;
      }
    }
  }
  return nullptr;
}

constexpr openni::PixelFormat kColorFormats[] = {openni::PIXEL_FORMAT_RGB888};
constexpr openni::PixelFormat kDepthFormats[] = {openni::PIXEL_FORMAT_DEPTH_1_MM,
                                                 openni::PIXEL_FORMAT_DEPTH_100_UM};

// A focal length (px) from the angle (rad) under which `size` pixels are seen.
double focal_length_px(int size, double field_of_view_rad) {
  return size / (2 * std::tan(field_of_view_rad / 2));
}

template <typename Pixel>
image::Image<Pixel> copy_pixels(const openni::VideoFrameRef& frame) {
  image::Image<Pixel> picture(frame.getWidth(), frame.getHeight());
  const auto* bytes = static_cast<const std::uint8_t*>(frame.getData());
  const auto stride = static_cast<std::size_t>(frame.getStrideInBytes());
  for (int y = 0; y < picture.height(); ++y) {
    const auto row = picture.row(y);
    std::memcpy(row.data(), bytes + static_cast<std::size_t>(y) * stride, row.size_bytes());
  }
  return picture;
}

}  // namespace

Expected<void> OpenNi2Options::validate() const {
  if (!std::isfinite(timeout_s) || timeout_s <= 0 || timeout_s > 3600) {
    return fail("timeout_s = {} must be positive, at most 3600", timeout_s);
  }
  if (camera) ROOMWISE_RETURN_IF_ERROR(camera->validate());
  return {};
}

// The open device. Members are closed in the reverse of their order here, as OpenNI wants it.
class OpenNi2Source::Session {
 public:
  explicit Session(const OpenNi2Options& options) : options_(options) {}

  [[nodiscard]] Expected<void> open();
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next();
  void skip_before(std::uint64_t index);
  [[nodiscard]] const SourceInfo& info() const { return info_; }

 private:
  [[nodiscard]] Expected<void> open_device();
  [[nodiscard]] Expected<void> create_stream(Stream& stream);
  [[nodiscard]] Expected<void> configure_file();
  [[nodiscard]] Expected<void> configure_camera();
  [[nodiscard]] Expected<void> choose_mode(Stream& stream,
                                           std::span<const openni::PixelFormat> formats);
  [[nodiscard]] Expected<void> check_streams() const;
  [[nodiscard]] Expected<geometry::PinholeCamera> camera_of_streams() const;

  [[nodiscard]] Expected<void> read_any(Clock::time_point deadline);
  [[nodiscard]] Unexpected too_late() const;
  [[nodiscard]] bool bring_pair_to_front();
  [[nodiscard]] Expected<image::RgbdFrame> take_front_pair();
  void drop_front_pair();
  void count_remaining();

  OpenNi2Options options_;
  SourceInfo info_;
  std::uint64_t next_index_ = 0;
  std::uint64_t first_wanted_index_ = 0;
  TimestampNs last_timestamp_ns_ = std::numeric_limits<TimestampNs>::min();
  Library library_;
  openni::Device device_;
  Stream color_{.name = "colour", .sensor = openni::SENSOR_COLOR};
  Stream depth_{.name = "depth", .sensor = openni::SENSOR_DEPTH};
};

Expected<void> OpenNi2Source::Session::open() {
  if (!library_.started()) return fail("OpenNI 2 does not start: {}", openni_reason());
  ROOMWISE_RETURN_IF_ERROR(open_device());
  for (Stream* stream : {&color_, &depth_}) ROOMWISE_RETURN_IF_ERROR(create_stream(*stream));
  ROOMWISE_RETURN_IF_ERROR(device_.isFile() ? configure_file() : configure_camera());
  ROOMWISE_RETURN_IF_ERROR(check_streams());
  ROOMWISE_TRY(info_.camera, camera_of_streams());
  for (Stream* stream : {&color_, &depth_}) {
    if (stream->stream.start() != openni::STATUS_OK) {
      return fail("{}: its {} stream does not start: {}", info_.name, stream->name,
                  openni_reason());
    }
  }
  return {};
}

Expected<void> OpenNi2Source::Session::open_device() {
  const bool any = options_.uri.empty();
  if (device_.open(any ? openni::ANY_DEVICE : options_.uri.c_str()) != openni::STATUS_OK) {
    if (any) {
      return fail(
          "OpenNI 2 finds no camera ({}); plug one in, and see that its driver is there and "
          "that you may use it (udev rules)",
          openni_reason());
    }
    return fail("{}: OpenNI 2 opens no such device or recording ({})", options_.uri,
                openni_reason());
  }
  const openni::DeviceInfo& device = device_.getDeviceInfo();
  info_.name =
      device_.isFile() ? options_.uri : fmt::format("{} {}", device.getVendor(), device.getName());
  return {};
}

Expected<void> OpenNi2Source::Session::create_stream(Stream& stream) {
  if (!device_.hasSensor(stream.sensor)) {
    return fail("{}: has no {} stream; colour and depth are needed", info_.name, stream.name);
  }
  if (stream.stream.create(device_, stream.sensor) != openni::STATUS_OK) {
    return fail("{}: gives no {} stream: {}", info_.name, stream.name, openni_reason());
  }
  return {};
}

// A recording is read frame by frame, as fast as it is asked for, once. It is set to repeat itself
// nevertheless, and left before it does (read_any): a player that is at its end without repeating
// goes round in circles through its list of streams, and crashes when they are closed.
Expected<void> OpenNi2Source::Session::configure_file() {
  constexpr float kOnDemand = -1;
  openni::PlaybackControl& playback = *device_.getPlaybackControl();
  if (playback.setSpeed(kOnDemand) != openni::STATUS_OK ||
      playback.setRepeatEnabled(true) != openni::STATUS_OK) {
    return fail("{}: cannot be played frame by frame: {}", info_.name, openni_reason());
  }
  for (Stream* stream : {&color_, &depth_}) {
    stream->frames_in_file = playback.getNumberOfFrames(stream->stream);
    if (stream->frames_in_file <= 0) {
      return fail("{}: holds no {} frame", info_.name, stream->name);
    }
  }
  count_remaining();
  return {};
}

Expected<void> OpenNi2Source::Session::configure_camera() {
  ROOMWISE_RETURN_IF_ERROR(choose_mode(color_, kColorFormats));
  ROOMWISE_RETURN_IF_ERROR(choose_mode(depth_, kDepthFormats));
  const auto registration = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (!device_.isImageRegistrationModeSupported(registration) ||
      device_.setImageRegistrationMode(registration) != openni::STATUS_OK) {
    return fail("{}: cannot register its depth to its colour; use an Asus Xtion or a Kinect v1",
                info_.name);
  }
  for (Stream* stream : {&color_, &depth_}) stream->stream.setMirroringEnabled(false);
  // Where the device cannot, frames are still paired by their times.
  device_.setDepthColorSyncEnabled(true);
  return {};
}

Expected<void> OpenNi2Source::Session::choose_mode(Stream& stream,
                                                   std::span<const openni::PixelFormat> formats) {
  const openni::VideoMode* mode = find_mode(stream.stream.getSensorInfo(), formats);
  if (mode == nullptr) {
    return fail("{}: its {} stream has no {}x{} at {} frames a second in a format that is read",
                info_.name, stream.name, kWidth, kHeight, kFramesPerSecond);
  }
  if (stream.stream.setVideoMode(*mode) != openni::STATUS_OK) {
    return fail("{}: its {} stream does not take {}x{} at {} frames a second: {}", info_.name,
                stream.name, kWidth, kHeight, kFramesPerSecond, openni_reason());
  }
  return {};
}

// What the streams will give must be what next() takes.
Expected<void> OpenNi2Source::Session::check_streams() const {
  const openni::VideoMode color = color_.stream.getVideoMode();
  const openni::VideoMode depth = depth_.stream.getVideoMode();
  if (std::ranges::find(kColorFormats, color.getPixelFormat()) == std::end(kColorFormats)) {
    return fail("{}: its colour is not 8-bit RGB; record it so", info_.name);
  }
  if (std::ranges::find(kDepthFormats, depth.getPixelFormat()) == std::end(kDepthFormats)) {
    return fail("{}: its depth is not in millimetres or tenths of them; record it so", info_.name);
  }
  if (depth.getResolutionX() != color.getResolutionX() ||
      depth.getResolutionY() != color.getResolutionY()) {
    return fail("{}: has {}x{} colour and {}x{} depth pixels; record both in one size", info_.name,
                color.getResolutionX(), color.getResolutionY(), depth.getResolutionX(),
                depth.getResolutionY());
  }
  if (color_.stream.getMirroringEnabled() || depth_.stream.getMirroringEnabled()) {
    return fail("{}: its pictures are mirrored; record them with mirroring off", info_.name);
  }
  return {};
}

Expected<geometry::PinholeCamera> OpenNi2Source::Session::camera_of_streams() const {
  const int width = color_.stream.getVideoMode().getResolutionX();
  const int height = color_.stream.getVideoMode().getResolutionY();
  geometry::PinholeCamera camera;
  if (options_.camera) {
    camera = *options_.camera;
    if (camera.width != width || camera.height != height) {
      return fail("{}: has {}x{} pixels, the camera given {}x{}; give the one of this device",
                  info_.name, width, height, camera.width, camera.height);
    }
  } else {
    const double horizontal_rad = color_.stream.getHorizontalFieldOfView();
    const double vertical_rad = color_.stream.getVerticalFieldOfView();
    if (!(horizontal_rad > 0) || !(vertical_rad > 0)) {
      return fail("{}: does not tell its field of view; give --camera", info_.name);
    }
    camera.width = width;
    camera.height = height;
    camera.fx = focal_length_px(width, horizontal_rad);
    camera.fy = focal_length_px(height, vertical_rad);
    camera.cx = (width - 1) / 2.0;
    camera.cy = (height - 1) / 2.0;
  }
  const bool millimetres =
      depth_.stream.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM;
  camera.depth_units_per_metre = millimetres ? 1000 : 10'000;
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  return camera;
}

Expected<std::optional<image::RgbdFrame>> OpenNi2Source::Session::next() {
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(options_.timeout_s));
  for (;;) {
    if (!bring_pair_to_front()) {
      if (color_.at_end() && depth_.at_end()) return std::optional<image::RgbdFrame>();
      ROOMWISE_RETURN_IF_ERROR(read_any(deadline));
      count_remaining();
    } else if (next_index_ < first_wanted_index_) {
      drop_front_pair();
    } else {
      return take_front_pair();
    }
  }
}

void OpenNi2Source::Session::skip_before(std::uint64_t index) {
  if (device_.isFile()) first_wanted_index_ = index;
}

// Reads a frame of the stream that has one first. Reading each as it comes loses none, as waiting
// for one stream would of the other.
Expected<void> OpenNi2Source::Session::read_any(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
  if (left.count() <= 0) return too_late();
  std::vector<Stream*> streams;
  std::vector<openni::VideoStream*> handles;
  for (Stream* stream : {&color_, &depth_}) {
    if (stream->at_end()) continue;
    streams.push_back(stream);
    handles.push_back(&stream->stream);
  }
  int ready = 0;
  const openni::Status status = openni::OpenNI::waitForAnyStream(
      handles.data(), static_cast<int>(handles.size()), &ready, static_cast<int>(left.count()));
  if (status == openni::STATUS_TIME_OUT) return too_late();
  if (status != openni::STATUS_OK) {
    return fail("{}: cannot wait for a frame: {}", info_.name, openni_reason());
  }
  Stream& stream = *streams[static_cast<std::size_t>(ready)];
  openni::VideoFrameRef frame;
  if (stream.stream.readFrame(&frame) != openni::STATUS_OK || !frame.isValid()) {
    return fail("{}: cannot read a {} frame: {}", info_.name, stream.name, openni_reason());
  }
  if (device_.isFile() && frame.getFrameIndex() <= stream.frames_passed) {
    stream.frames_passed = stream.frames_in_file;  // fewer than it promised: it began again
    return {};
  }
  stream.frames_passed = frame.getFrameIndex();
  stream.waiting.push_back(frame);
  if (stream.waiting.size() > kMaxWaiting) stream.waiting.pop_front();
  return {};
}

Unexpected OpenNi2Source::Session::too_late() const {
  const char* missing = color_.waiting.empty()   ? "colour"
                        : depth_.waiting.empty() ? "depth"
                                                 : "matching";
  return fail("{}: gave no {} frame for {} s; see that it is plugged in", info_.name, missing,
              options_.timeout_s);
}

// Drops what came before the first two frames that belong together; false where no two do.
bool OpenNi2Source::Session::bring_pair_to_front() {
  for (auto color = color_.waiting.begin(); color != color_.waiting.end(); ++color) {
    const auto depth = std::ranges::find_if(depth_.waiting, [&](const auto& candidate) {
      return std::abs(timestamp_ns(*color) - timestamp_ns(candidate)) <= kHalfFramePeriodNs;
    });
    if (depth == depth_.waiting.end()) continue;
    color_.waiting.erase(color_.waiting.begin(), color);
    depth_.waiting.erase(depth_.waiting.begin(), depth);
    return true;
  }
  return false;
}

void OpenNi2Source::Session::drop_front_pair() {
  color_.waiting.pop_front();
  depth_.waiting.pop_front();
  ++next_index_;
}

Expected<image::RgbdFrame> OpenNi2Source::Session::take_front_pair() {
  image::RgbdFrame frame;
  frame.index = next_index_;
  frame.timestamp_ns = timestamp_ns(color_.waiting.front());
  frame.color = copy_pixels<Rgb8>(color_.waiting.front());
  frame.depth = copy_pixels<std::uint16_t>(depth_.waiting.front());
  drop_front_pair();
  const geometry::PinholeCamera& camera = info_.camera;
  if (frame.color.width() != camera.width || frame.color.height() != camera.height ||
      frame.depth.width() != camera.width || frame.depth.height() != camera.height) {
    return fail("{}: frame {} is not of {}x{} pixels; leave its modes alone while it is read",
                info_.name, frame.index, camera.width, camera.height);
  }
  if (frame.timestamp_ns <= last_timestamp_ns_) {
    return fail("{}: the clock went back to {} s at frame {}; start again", info_.name,
                format_timestamp(frame.timestamp_ns), frame.index);
  }
  last_timestamp_ns_ = frame.timestamp_ns;
  return frame;
}

void OpenNi2Source::Session::count_remaining() {
  if (!device_.isFile()) return;
  const int remaining = std::min(color_.frames_in_file - color_.frames_passed,
                                 depth_.frames_in_file - depth_.frames_passed);
  info_.frames_remaining = static_cast<std::uint64_t>(std::max(remaining, 0));
}

OpenNi2Source::OpenNi2Source(std::unique_ptr<Session> session) : session_(std::move(session)) {}
OpenNi2Source::~OpenNi2Source() = default;

Expected<std::unique_ptr<OpenNi2Source>> OpenNi2Source::open(const OpenNi2Options& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  auto session = std::make_unique<Session>(options);
  ROOMWISE_RETURN_IF_ERROR(session->open());
  return std::unique_ptr<OpenNi2Source>(new OpenNi2Source(std::move(session)));
}

const SourceInfo& OpenNi2Source::info() const {
  return session_->info();
}

Expected<std::optional<image::RgbdFrame>> OpenNi2Source::next() {
  return session_->next();
}

void OpenNi2Source::skip_before(std::uint64_t index) {
  session_->skip_before(index);
}

}  // namespace roomwise::recording
