#include "roomwise/recording/phone/record3d_files.h"

#include <array>

#include "roomwise/base/byte_reader.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/bytes/exr.h"
#include "roomwise/recording/bytes/lzfse.h"
#include "roomwise/recording/phone/zip_file.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::uint8_t kMinRecord3dConfidence = 1;
constexpr std::size_t kMaxMetadataBytes = std::size_t{1} << 27;
constexpr std::size_t kMaxJpegBytes = std::size_t{1} << 26;

class Record3dZip final : public Record3dFiles {
 public:
  explicit Record3dZip(ZipFile zip) : zip_(std::move(zip)) {}

  [[nodiscard]] const char* kind() const override { return "Record3D .r3d"; }
  [[nodiscard]] const fs::path& path() const override { return zip_.path(); }
  [[nodiscard]] std::string name_of_metadata() const override { return named("metadata"); }
  [[nodiscard]] std::string name_of_color(std::size_t frame) const override {
    return named(entry(frame, "jpg"));
  }
  [[nodiscard]] bool has_color(std::size_t frame) const override {
    return zip_.contains(entry(frame, "jpg"));
  }
  [[nodiscard]] bool has_depth(std::size_t frame) const override {
    return zip_.contains(entry(frame, "depth"));
  }
  [[nodiscard]] Expected<Bytes> read_metadata() const override {
    return zip_.read("metadata", kMaxMetadataBytes);
  }
  [[nodiscard]] Expected<Bytes> read_color(std::size_t frame) const override {
    return zip_.read(entry(frame, "jpg"), kMaxJpegBytes);
  }
  [[nodiscard]] Expected<image::Image<float>> read_depth_m(std::size_t frame, int width,
                                                           int height) const override {
    image::Image<float> depth_m(width, height);
    ROOMWISE_TRY(const Bytes metres,
                 read_values(entry(frame, "depth"), sizeof(float), width, height));
    Bytes confidence;
    if (zip_.contains(entry(frame, "conf"))) {
      ROOMWISE_TRY(confidence, read_values(entry(frame, "conf"), 1, width, height));
    }
    for (std::size_t i = 0; i < depth_m.pixels().size(); ++i) {
      if (!confidence.empty() && confidence[i] < kMinRecord3dConfidence) continue;
      depth_m.pixels()[i] = load<float>(metres.data() + sizeof(float) * i);
    }
    return depth_m;
  }

 private:
  static std::string entry(std::size_t frame, std::string_view ending) {
    return fmt::format("rgbd/{}.{}", frame, ending);
  }
  [[nodiscard]] std::string named(const std::string& entry) const {
    return fmt::format("{}: {}", zip_.path().string(), entry);
  }
  // One value of `size` bytes for each pixel of depth, packed or as it is.
  [[nodiscard]] Expected<Bytes> read_values(const std::string& entry, std::size_t size, int width,
                                            int height) const {
    const std::size_t expected =
        size * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    ROOMWISE_TRY(Bytes bytes, zip_.read(entry, 2 * expected + 4096));
    if (is_lzfse(bytes) && bytes.size() != expected) {
      ROOMWISE_TRY(bytes, in_context(named(entry), decode_lzfse(bytes, expected)));
    }
    if (bytes.size() == expected) return bytes;
    return fail("{}: has {} bytes, {}x{} pixels need {}", named(entry), bytes.size(), width, height,
                expected);
  }

  ZipFile zip_;
};

// A picture of a frame; an empty path where there is none.
fs::path color_in(const fs::path& folder, std::size_t frame) {
  std::error_code ignored;
  for (const char* ending : {"jpg", "png"}) {
    fs::path file = folder / "rgb" / fmt::format("{}.{}", frame, ending);
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return {};
}

Expected<Bytes> read_at_most(const fs::path& file, std::size_t max_bytes) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (!error && size > max_bytes) {
    return fail("{}: has {} bytes, more than the {} that such a file may have", file.string(), size,
                max_bytes);
  }
  return read_file(file);
}

class Record3dExrFolder final : public Record3dFiles {
 public:
  explicit Record3dExrFolder(fs::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] const char* kind() const override { return "Record3D, EXR and JPG"; }
  [[nodiscard]] const fs::path& path() const override { return folder_; }
  [[nodiscard]] std::string name_of_metadata() const override { return metadata().string(); }
  [[nodiscard]] std::string name_of_color(std::size_t frame) const override {
    return color_in(folder_, frame).string();
  }
  [[nodiscard]] bool has_color(std::size_t frame) const override {
    return !color_in(folder_, frame).empty();
  }
  [[nodiscard]] bool has_depth(std::size_t frame) const override {
    std::error_code ignored;
    return fs::is_regular_file(depth(frame), ignored);
  }
  [[nodiscard]] Expected<Bytes> read_metadata() const override {
    return read_at_most(metadata(), kMaxMetadataBytes);
  }
  [[nodiscard]] Expected<Bytes> read_color(std::size_t frame) const override {
    return read_at_most(color_in(folder_, frame), kMaxJpegBytes);
  }
  [[nodiscard]] Expected<image::Image<float>> read_depth_m(std::size_t frame, int width,
                                                           int height) const override {
    constexpr std::size_t kMaxBytesOfPixel = 64;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    ROOMWISE_TRY(const Bytes bytes,
                 read_at_most(depth(frame), kMaxBytesOfPixel * pixels + (1 << 20)));
    ROOMWISE_TRY(auto depth_m, in_context(depth(frame).string(),
                                          decode_exr(bytes, static_cast<std::int64_t>(pixels))));
    if (depth_m.width() == width && depth_m.height() == height) return depth_m;
    return fail("{}: has {}x{} pixels, metadata.json says {}x{}", depth(frame).string(),
                depth_m.width(), depth_m.height(), width, height);
  }

 private:
  [[nodiscard]] fs::path metadata() const { return folder_ / "metadata.json"; }
  [[nodiscard]] fs::path depth(std::size_t frame) const {
    return folder_ / "depth" / fmt::format("{}.exr", frame);
  }

  fs::path folder_;
};

}  // namespace

Expected<std::unique_ptr<Record3dFiles>> open_record3d_zip(const fs::path& path) {
  ROOMWISE_TRY(ZipFile zip, ZipFile::open(path));
  return std::unique_ptr<Record3dFiles>(std::make_unique<Record3dZip>(std::move(zip)));
}

std::unique_ptr<Record3dFiles> open_record3d_exr(const fs::path& folder) {
  return std::make_unique<Record3dExrFolder>(find_record3d_folder(folder));
}

fs::path find_record3d_folder(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::path& one : {folder, folder / "EXR_RGBD"}) {
    if (fs::is_regular_file(one / "metadata.json", ignored) &&
        fs::is_directory(one / "depth", ignored) && !color_in(one, 0).empty()) {
      return one;
    }
  }
  return {};
}

}  // namespace roomwise::recording
