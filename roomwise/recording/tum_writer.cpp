#include "roomwise/recording/tum_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <tuple>
#include <utility>

#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/camera_file.h"

namespace roomwise::recording {
namespace {

constexpr int kJpegQuality = 95;
constexpr double kBetweenRooms_s = 5;  // that rooms.txt may be behind

// A new file that is written as it grows. Not write_file(), which waits for the disk: a camera does
// not wait, and a killed recording needs only what the system took over.
class NewFile {
 public:
  explicit NewFile(std::filesystem::path path)
      : path_(std::move(path)),
        descriptor_(
            ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644)),
        open_error_(descriptor_ < 0 ? errno : 0) {}
  ~NewFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  // All of the bytes, or none.
  [[nodiscard]] Expected<void> append(std::span<const std::uint8_t> bytes) {
    if (descriptor_ < 0) return failed(open_error_);
    std::size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t put = ::write(descriptor_, bytes.data() + written, bytes.size() - written);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) {
        auto error = failed(errno);
        cut_to(size_);
        return error;
      }
      written += static_cast<std::size_t>(put);
    }
    size_ += written;
    return {};
  }
  [[nodiscard]] Expected<void> append(std::string_view text) {
    return append(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  void cut_to(std::size_t size) {
    if (::ftruncate(descriptor_, static_cast<off_t>(size)) == 0) size_ = size;
  }

  [[nodiscard]] Expected<void> flush_to_disk() {
    if (::fsync(descriptor_) != 0) return failed(errno);
    return {};
  }

 private:
  [[nodiscard]] Unexpected failed(int error) const {
    const ErrorCode code = code_of_write_error(error);
    const char* mend = code == ErrorCode::kDiskFull
                           ? "; what was recorded before is kept, free some space to go on"
                           : "";
    return fail_with(code, "{}: cannot be written: {}{}", path_.string(), std::strerror(error),
                     mend);
  }

  std::filesystem::path path_;
  int descriptor_;
  int open_error_;
  std::size_t size_ = 0;
};

Expected<void> write_new_file(const std::filesystem::path& path,
                              std::span<const std::uint8_t> bytes) {
  return NewFile(path).append(bytes);
}

Expected<void> make_empty_folder(const std::filesystem::path& folder) {
  std::error_code error;
  for (const auto& part : {folder, folder / "rgb", folder / "depth"}) {
    if (part == folder && std::filesystem::exists(folder, error) &&
        !std::filesystem::is_empty(folder, error)) {
      return fail("{}: is there and not empty; give a new folder for the recording",
                  folder.string());
    }
    if (!std::filesystem::create_directories(part, error) && error) {
      return fail("{}: cannot be made: {}", part.string(), error.message());
    }
    // Pictures of where somebody lives are for nobody else on the machine.
    std::filesystem::permissions(part, std::filesystem::perms::owner_all, error);
  }
  return {};
}

}  // namespace

image::RgbdFrame encode_images(image::RgbdFrame frame) {
  if (frame.encoded_depth.empty()) frame.encoded_depth = image::encode_png(frame.depth);
  if (frame.encoded_color.empty()) {
    frame.encoded_color = image::encode_jpeg(frame.color, kJpegQuality);
  }
  return frame;
}

// rgb.txt or depth.txt, and the images in it.
class TumWriter::List {
 public:
  List(std::filesystem::path folder, std::string name)
      : folder_(std::move(folder)), name_(std::move(name)), file_(folder_ / (name_ + ".txt")) {}

  [[nodiscard]] Expected<void> begin() { return file_.append("# timestamp filename\n"); }

  // Writes the image, then its line.
  [[nodiscard]] Expected<void> add(TimestampNs timestamp_ns, std::span<const std::uint8_t> bytes) {
    const std::string time = format_timestamp(timestamp_ns);
    const std::string image =
        fmt::format("{}/{}.{}", name_, time, image::is_jpeg(bytes) ? "jpg" : "png");
    last_image_ = folder_ / image;
    size_before_last_ = file_.size();
    auto written = write_new_file(last_image_, bytes);
    if (written) written = file_.append(fmt::format("{} {}\n", time, image));
    if (!written) take_back();
    return written;
  }

  // Takes back the image added last.
  void take_back() {
    file_.cut_to(size_before_last_);
    std::error_code ignored;
    std::filesystem::remove(last_image_, ignored);
  }

  [[nodiscard]] Expected<void> flush_to_disk() { return file_.flush_to_disk(); }

 private:
  std::filesystem::path folder_;
  std::string name_;
  NewFile file_;
  std::filesystem::path last_image_;
  std::size_t size_before_last_ = 0;
};

// odometry.txt.
class TumWriter::MotionFile {
 public:
  explicit MotionFile(const std::filesystem::path& folder) : file_(folder / "odometry.txt") {}

  // Which way is up is said once, as soon as the device knows it; how sure it is, behind its pose.
  [[nodiscard]] Expected<void> add(TimestampNs timestamp_ns, const geometry::DeviceMotion& device,
                                   const std::optional<PoseCovariance>& covariance) {
    size_before_last_ = file_.size();
    had_up_ = has_up_;
    std::string lines = size_before_last_ == 0 ? "# the device's own motion\n" : "";
    if (device.up_camera && !has_up_) {
      lines += up_line(device.world_from_camera.rotation * *device.up_camera);
      has_up_ = true;
    }
    lines += trajectory_line({timestamp_ns, device.world_from_camera});
    if (covariance) {
      lines.pop_back();
      lines += " # covariance";
      for (int row = 0; row < 6; ++row) {
        for (int column = row; column < 6; ++column) {
          lines += fmt::format(" {:.9g}", (*covariance)(row, column));
        }
      }
      lines += '\n';
    }
    auto added = file_.append(lines);
    if (!added) has_up_ = had_up_;
    return added;
  }

  // Takes back the pose added last.
  void take_back() {
    file_.cut_to(size_before_last_);
    has_up_ = had_up_;
  }

  [[nodiscard]] Expected<void> flush_to_disk() { return file_.flush_to_disk(); }

 private:
  NewFile file_;
  std::size_t size_before_last_ = 0;
  bool has_up_ = false, had_up_ = false;
};

TumWriter::TumWriter(std::filesystem::path folder, const geometry::PinholeCamera& camera)
    : folder_(std::move(folder)),
      camera_(camera),
      color_list_(std::make_unique<List>(folder_, "rgb")),
      depth_list_(std::make_unique<List>(folder_, "depth")) {}

Expected<std::unique_ptr<TumWriter>> TumWriter::create(const std::filesystem::path& folder,
                                                       const geometry::PinholeCamera& camera) {
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  ROOMWISE_RETURN_IF_ERROR(make_empty_folder(folder));
  ROOMWISE_RETURN_IF_ERROR(write_camera(folder / "camera.txt", camera));
  std::unique_ptr<TumWriter> writer(new TumWriter(folder, camera));
  ROOMWISE_RETURN_IF_ERROR(writer->color_list_->begin());
  ROOMWISE_RETURN_IF_ERROR(writer->depth_list_->begin());
  return writer;
}

TumWriter::~TumWriter() {
  std::ignore = close();
}

Expected<void> TumWriter::check(const image::RgbdFrame& frame) const {
  if (color_list_ == nullptr) return fail("{}: the recording is closed", folder_.string());
  if (frames_ > 0 && frame.timestamp_ns <= last_timestamp_ns_) {
    return fail("{}: the frame's time {} does not increase (the last was {})", folder_.string(),
                format_timestamp(frame.timestamp_ns), format_timestamp(last_timestamp_ns_));
  }
  const auto has_size = [&](const auto& picture) {
    return picture.width() == camera_.width && picture.height() == camera_.height;
  };
  if (!has_size(frame.color) || !has_size(frame.depth)) {
    return fail("{}: the frame has {}x{} colour and {}x{} depth pixels, the camera {}x{}",
                folder_.string(), frame.color.width(), frame.color.height(), frame.depth.width(),
                frame.depth.height(), camera_.width, camera_.height);
  }
  const Bytes& color = frame.encoded_color;
  const Bytes& depth = frame.encoded_depth;
  if ((!color.empty() && !image::is_jpeg(color) && !image::is_png(color)) ||
      (!depth.empty() && !image::is_png(depth))) {
    return fail("{}: the frame's encoded images are not JPEG or PNG and PNG", folder_.string());
  }
  return {};
}

Expected<void> TumWriter::write(const image::RgbdFrame& frame,
                                const std::optional<PoseCovariance>& covariance) {
  ROOMWISE_RETURN_IF_ERROR(check(frame));
  if (frame.device_motion && motion_ == nullptr) motion_ = std::make_unique<MotionFile>(folder_);
  if (frame.device_motion) {
    ROOMWISE_RETURN_IF_ERROR(motion_->add(frame.timestamp_ns, *frame.device_motion, covariance));
  }
  auto depth_added = depth_list_->add(frame.timestamp_ns, image::depth_file(frame));
  if (!depth_added) {
    if (frame.device_motion) motion_->take_back();
    return depth_added;
  }
  auto color_added =
      color_list_->add(frame.timestamp_ns, frame.encoded_color.empty()
                                               ? image::encode_jpeg(frame.color, kJpegQuality)
                                               : image::color_file(frame));
  if (!color_added) {
    depth_list_->take_back();
    if (frame.device_motion) motion_->take_back();
    return color_added;
  }
  const bool enters_room = note_room_of_next_frame();
  ++frames_;
  last_timestamp_ns_ = frame.timestamp_ns;
  const bool is_due = seconds_between(rooms_kept_ns_, last_timestamp_ns_) >= kBetweenRooms_s;
  // The frame is stored whatever becomes of this; the next one tries again.
  if (room_ && (enters_room || is_due)) std::ignore = keep_rooms();
  return {};
}

bool TumWriter::note_room_of_next_frame() {
  if (!room_) return false;
  const bool stays =
      !rooms_.empty() && rooms_.back().room == *room_ && rooms_.back().last_frame + 1 == frames_;
  if (stays) {
    rooms_.back().last_frame = frames_;
    return false;
  }
  const auto visits = std::ranges::count(rooms_, *room_, &RoomRange::room);
  rooms_.push_back({frames_, frames_, *room_, static_cast<int>(visits) + 1});
  return true;
}

Expected<void> TumWriter::name_room(std::optional<std::string> room) {
  if (color_list_ == nullptr) return fail("{}: the recording is closed", folder_.string());
  if (room) ROOMWISE_RETURN_IF_ERROR(validate_room_name(*room));
  if (room == room_) return {};
  room_ = std::move(room);
  return keep_rooms();
}

// In one piece, and not waiting for the disk (NewFile).
Expected<void> TumWriter::keep_rooms() {
  if (rooms_.empty()) return {};
  ROOMWISE_TRY(const RoomLabels labels, RoomLabels::from_ranges(rooms_));
  const std::filesystem::path file = folder_ / "rooms.txt", part = folder_ / "rooms.txt.part";
  std::error_code error;
  std::filesystem::remove(part, error);  // of one that failed
  ROOMWISE_RETURN_IF_ERROR(NewFile(part).append(labels.text()));
  std::filesystem::rename(part, file, error);
  if (error) return fail("{}: cannot be put in place: {}", file.string(), error.message());
  rooms_kept_ns_ = last_timestamp_ns_;
  return {};
}

Expected<void> TumWriter::close() {
  if (color_list_ == nullptr) return {};
  if (!rooms_.empty()) {
    ROOMWISE_TRY(const RoomLabels labels, RoomLabels::from_ranges(rooms_));
    ROOMWISE_RETURN_IF_ERROR(labels.write(folder_ / "rooms.txt"));
  }
  if (motion_ != nullptr) ROOMWISE_RETURN_IF_ERROR(motion_->flush_to_disk());
  ROOMWISE_RETURN_IF_ERROR(depth_list_->flush_to_disk());
  ROOMWISE_RETURN_IF_ERROR(color_list_->flush_to_disk());
  depth_list_.reset();
  color_list_.reset();
  return {};
}

}  // namespace roomwise::recording
