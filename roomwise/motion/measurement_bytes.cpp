#include "roomwise/motion/measurement_bytes.h"

#include <cstring>
#include <type_traits>
#include <utility>

namespace roomwise::motion {
namespace {

static_assert(std::is_trivially_copyable_v<geometry::PinholeCamera>);

class Writer {
 public:
  template <typename T>
  void put(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t end = bytes_.size();
    bytes_.resize(end + count * sizeof(T));
    if (count > 0) std::memcpy(bytes_.data() + end, values, count * sizeof(T));
  }
  template <typename T>
  void put(const T& value) {
    put(&value, 1);
  }
  [[nodiscard]] Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Reads zeros from where the bytes end, and remembers that.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  template <typename T>
  void get(T* values, std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (size > rest_.size()) {
      is_short_ = true;
      rest_ = {};
    }
    if (size == 0 || is_short_) return;
    std::memcpy(values, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  template <typename T>
  [[nodiscard]] T get() {
    T value{};
    get(&value, 1);
    return value;
  }
  // A number of things of which each takes so many bytes; 0 where there cannot be as many.
  [[nodiscard]] std::size_t get_count(std::size_t bytes_each) {
    const auto count = get<std::uint64_t>();
    if (count <= rest_.size() / bytes_each) return count;
    is_short_ = true;
    return 0;
  }
  // How long the rows are that follow; 0 where there cannot be as many so long.
  [[nodiscard]] std::size_t get_columns(std::size_t rows, std::size_t bytes_each) {
    constexpr std::uint64_t kMax = 65536;
    const auto columns = get<std::uint64_t>();
    if (columns <= kMax && columns * rows * bytes_each <= rest_.size()) return columns;
    is_short_ = true;
    return 0;
  }
  [[nodiscard]] bool is_whole() const { return !is_short_ && rest_.empty(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool is_short_ = false;
};

template <typename Pixel>
void put_image(Writer& writer, const image::Image<Pixel>& image) {
  writer.put(image.pixels().data(), image.pixels().size());
}

template <typename Pixel>
void get_image(Reader& reader, image::Image<Pixel>& image) {
  reader.get(image.pixels().data(), image.pixels().size());
}

// A key-point as plain numbers.
struct PlainKeypoint {
  float x, y, size, angle, response;
  std::uint32_t bright;
};

void put_features(Writer& writer, const MeasuredFeatures& measured) {
  const std::size_t count = measured.size();
  const bool is_real =
      std::holds_alternative<features::RealDescriptors>(measured.features.descriptors);
  writer.put(static_cast<std::uint64_t>(count));
  writer.put(static_cast<std::uint64_t>(is_real ? 1 : 0));
  for (const features::Keypoint& keypoint : measured.features.keypoints) {
    writer.put(PlainKeypoint{keypoint.position_px.x(), keypoint.position_px.y(), keypoint.size_px,
                             keypoint.angle_rad, keypoint.response, keypoint.bright ? 1U : 0U});
  }
  for (const Eigen::Vector2d& pixel : measured.pixels) writer.put(pixel.data(), 2);
  for (const Eigen::Vector3d& point : measured.points) writer.put(point.data(), 3);
  std::visit(
      [&](const auto& descriptors) {
        writer.put(static_cast<std::uint64_t>(descriptors.cols()));
        writer.put(descriptors.data(), static_cast<std::size_t>(descriptors.size()));
      },
      measured.features.descriptors);
}

template <typename Descriptors>
Descriptors get_descriptors(Reader& reader, std::size_t count) {
  const std::size_t columns = reader.get_columns(count, sizeof(typename Descriptors::Scalar));
  Descriptors descriptors(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(columns));
  reader.get(descriptors.data(), static_cast<std::size_t>(descriptors.size()));
  return descriptors;
}

MeasuredFeatures get_features(Reader& reader) {
  MeasuredFeatures measured;
  const std::size_t count = reader.get_count(sizeof(PlainKeypoint));
  const bool is_real = reader.get<std::uint64_t>() == 1;
  for (std::size_t i = 0; i < count; ++i) {
    const auto plain = reader.get<PlainKeypoint>();
    measured.features.keypoints.push_back(
        {{plain.x, plain.y}, plain.size, plain.angle, plain.response, plain.bright == 1});
  }
  measured.pixels.resize(count);
  measured.points.resize(count);
  for (Eigen::Vector2d& pixel : measured.pixels) reader.get(pixel.data(), 2);
  for (Eigen::Vector3d& point : measured.points) reader.get(point.data(), 3);
  if (is_real) {
    measured.features.descriptors = get_descriptors<features::RealDescriptors>(reader, count);
  } else {
    measured.features.descriptors = get_descriptors<features::BinaryDescriptors>(reader, count);
  }
  return measured;
}

}  // namespace

std::size_t memory_bytes(const FrameMeasurements& measurements) {
  const MeasuredFeatures& features = measurements.features();
  std::size_t bytes = features.size() * (sizeof(features::Keypoint) + sizeof(Eigen::Vector2d) +
                                         sizeof(Eigen::Vector3d));
  bytes += std::visit(
      [](const auto& descriptors) {
        using Descriptors = std::decay_t<decltype(descriptors)>;
        return static_cast<std::size_t>(descriptors.size()) * sizeof(typename Descriptors::Scalar);
      },
      features.features.descriptors);
  for (const PyramidLevel& level : measurements.view().levels) {
    bytes +=
        sizeof(PyramidLevel) + level.gray.pixels().size_bytes() + level.depth.pixels().size_bytes();
  }
  return bytes;
}

Bytes to_bytes(const FrameMeasurements& measurements) {
  Writer writer;
  writer.put(static_cast<std::uint64_t>(measurements.view().levels.size()));
  for (const PyramidLevel& level : measurements.view().levels) {
    writer.put(level.camera);
    put_image(writer, level.gray);
    put_image(writer, level.depth);
  }
  put_features(writer, measurements.features());
  return writer.take();
}

Expected<FrameMeasurements> measurements_from_bytes(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  RgbdPyramid view;
  const std::size_t levels = reader.get_count(sizeof(geometry::PinholeCamera));
  for (std::size_t i = 0; i < levels; ++i) {
    const auto camera = reader.get<geometry::PinholeCamera>();
    PyramidLevel& level =
        view.levels.emplace_back(PyramidLevel{camera, image::GrayImage(camera.width, camera.height),
                                              image::DepthImage(camera.width, camera.height)});
    get_image(reader, level.gray);
    get_image(reader, level.depth);
  }
  MeasuredFeatures features = get_features(reader);
  if (!reader.is_whole()) return fail("{} bytes are no measurements of a frame", bytes.size());
  return FrameMeasurements(std::move(features), std::move(view));
}

}  // namespace roomwise::motion
