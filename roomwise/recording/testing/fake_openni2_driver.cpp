// A made-up depth camera for OpenNI 2, loaded by OpenNI itself as the driver of a real one is. Its
// URIs, beginning with "fake:", name what is to go wrong. Frame n comes at n / 30 s; colour is
// (n, x, y) and depth 1000 + n mm, both modulo 256 where they must be. Every fifth colour frame has
// no depth frame and the two streams are a millisecond apart.

#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>

// The two macros that ONI_EXPORT_DRIVER takes from a header that is not installed.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr float kHorizontalFovRad = 1.0F;
constexpr float kVerticalFovRad = 0.8F;

template <typename Value>
OniStatus give(const Value& value, void* data, int* size) {
  if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = sizeof value;
  return ONI_STATUS_OK;
}

class FakeStream final : public oni::driver::StreamBase {
 public:
  FakeStream(OniSensorType sensor, Clock::time_point begin, bool silent)
      : sensor_(sensor), begin_(begin), silent_(silent) {
    mode_.resolutionX = kWidth;
    mode_.resolutionY = kHeight;
    mode_.fps = 30;
    mode_.pixelFormat =
        sensor == ONI_SENSOR_COLOR ? ONI_PIXEL_FORMAT_RGB888 : ONI_PIXEL_FORMAT_DEPTH_1_MM;
  }
  ~FakeStream() override { FakeStream::stop(); }

  OniStatus start() override {
    running_ = true;
    if (!silent_) thread_ = std::thread([this] { play(); });
    return ONI_STATUS_OK;
  }
  void stop() override {
    {
      const std::lock_guard lock(mutex_);
      running_ = false;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  OniBool isPropertySupported(int id) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV ||
           id == ONI_STREAM_PROPERTY_VERTICAL_FOV || id == ONI_STREAM_PROPERTY_MIRRORING ||
           id == ONI_STREAM_PROPERTY_STRIDE || id == ONI_STREAM_PROPERTY_CROPPING;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return give(mode_, data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return give(kHorizontalFovRad, data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return give(kVerticalFovRad, data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return give(mirrored_, data, size);
      case ONI_STREAM_PROPERTY_STRIDE:  // this and the next: without them an .oni does not play
        return give(stride(), data, size);
      case ONI_STREAM_PROPERTY_CROPPING:
        return give(OniCropping{}, data, size);
      default:
        return ONI_STATUS_NOT_SUPPORTED;
    }
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE && size == sizeof mode_) {
      std::memcpy(&mode_, data, sizeof mode_);
      return ONI_STATUS_OK;
    }
    if (id == ONI_STREAM_PROPERTY_MIRRORING && size == sizeof mirrored_) {
      std::memcpy(&mirrored_, data, sizeof mirrored_);
      return ONI_STATUS_OK;
    }
    return ONI_STATUS_NOT_SUPPORTED;
  }

 private:
  [[nodiscard]] int stride() const { return kWidth * (sensor_ == ONI_SENSOR_COLOR ? 3 : 2); }

  // Both streams count the ticks of one clock, as those of a real camera do: a stream that comes
  // too late for a tick leaves it out.
  void play() {
    constexpr std::chrono::milliseconds kTick(10);  // a camera in a hurry: the tests are short
    for (int n = 0;;) {
      const bool no_depth = sensor_ == ONI_SENSOR_DEPTH && n % 5 == 4;
      if (!no_depth) give_frame(n);
      n = std::max(n + 1, static_cast<int>((Clock::now() - begin_) / kTick));
      std::unique_lock lock(mutex_);
      if (wake_.wait_until(lock, begin_ + n * kTick, [this] { return !running_; })) return;
    }
  }

  void give_frame(int n) {
    OniFrame* frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    const bool color = sensor_ == ONI_SENSOR_COLOR;
    frame->sensorType = sensor_;
    frame->frameIndex = n + 1;
    frame->timestamp = static_cast<std::uint64_t>(n) * 1'000'000 / 30 + (color ? 0 : 1000);
    frame->width = kWidth;
    frame->height = kHeight;
    frame->stride = stride();
    frame->dataSize = frame->stride * kHeight;
    frame->videoMode = mode_;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    color ? paint_color(frame, n) : paint_depth(frame, n);
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

  static void paint_color(OniFrame* frame, int n) {
    auto* pixel = static_cast<std::uint8_t*>(frame->data);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        *pixel++ = static_cast<std::uint8_t>(n);
        *pixel++ = static_cast<std::uint8_t>(x);
        *pixel++ = static_cast<std::uint8_t>(y);
      }
    }
  }

  static void paint_depth(OniFrame* frame, int n) {
    auto* pixel = static_cast<std::uint16_t*>(frame->data);
    for (int i = 0; i < kWidth * kHeight; ++i) *pixel++ = static_cast<std::uint16_t>(1000 + n);
  }

  OniSensorType sensor_;
  Clock::time_point begin_;
  bool silent_;
  OniVideoMode mode_{};
  OniBool mirrored_ = TRUE;  // as the real ones are at first
  std::mutex mutex_;
  std::condition_variable wake_;
  bool running_ = false;
  std::thread thread_;
};

class FakeDevice final : public oni::driver::DeviceBase {
 public:
  explicit FakeDevice(std::string uri) : uri_(std::move(uri)) {
    const bool small = uri_ == "fake:small";
    color_mode_ = {ONI_PIXEL_FORMAT_RGB888, small ? 320 : kWidth, small ? 240 : kHeight, 30};
    depth_mode_ = {ONI_PIXEL_FORMAT_DEPTH_1_MM, kWidth, kHeight, 30};
    sensors_[0] = {ONI_SENSOR_DEPTH, 1, &depth_mode_};
    sensors_[1] = {ONI_SENSOR_COLOR, 1, &color_mode_};
  }

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = uri_ == "fake:no-colour" ? 1 : 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    return new FakeStream(sensor, begin_, uri_ == "fake:silent");
  }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }

  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || uri_ != "fake:no-registration";
  }
  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    return give(registration_, data, size);
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != sizeof registration_) {
      return ONI_STATUS_NOT_SUPPORTED;
    }
    std::memcpy(&registration_, data, sizeof registration_);
    return ONI_STATUS_OK;
  }

 private:
  std::string uri_;
  Clock::time_point begin_ = Clock::now();
  OniVideoMode color_mode_{}, depth_mode_{};
  OniSensorInfo sensors_[2]{};
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
};

class FakeDriver final : public oni::driver::DriverBase {
 public:
  using DriverBase::DriverBase;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (std::getenv("ROOMWISE_FAKE_CAMERA_UNPLUGGED") == nullptr) announce("fake:camera");
    return ONI_STATUS_OK;
  }
  OniStatus tryDevice(const char* uri) override {
    if (std::string(uri).rfind("fake:", 0) != 0) return ONI_STATUS_ERROR;
    announce(uri);
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    return new FakeDevice(uri);
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

 private:
  void announce(const char* uri) {
    OniDeviceInfo info{};
    std::strncpy(info.uri, uri, sizeof info.uri - 1);
    std::strcpy(info.vendor, "Nobody");
    std::strcpy(info.name, "Fake camera");
    deviceConnected(&info);
  }
};

}  // namespace

ONI_EXPORT_DRIVER(FakeDriver)
