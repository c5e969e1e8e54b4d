#include "roomwise/motion/measurement_bytes.h"

#include <type_traits>
#include <utility>

#include "roomwise/base/plain_bytes.h"

namespace roomwise::motion {
namespace {

static_assert(std::is_trivially_copyable_v<geometry::PinholeCamera>);

template <typename Pixel>
void put_image(PlainWriter& writer, const image::Image<Pixel>& image) {
  writer.put(image.pixels().data(), image.pixels().size());
}

template <typename Pixel>
void get_image(PlainReader& reader, image::Image<Pixel>& image) {
  reader.get(image.pixels().data(), image.pixels().size());
}

// A key-point as plain numbers.
struct PlainKeypoint {
  float x, y, size, angle, response;
  std::uint32_t bright;
};

void put_features(PlainWriter& writer, const MeasuredFeatures& measured) {
  const std::size_t count = measured.size();
  const bool is_real =
      std::holds_alternative<features::FloatDescriptors>(measured.features.descriptors);
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
Descriptors get_descriptors(PlainReader& reader, std::size_t count) {
  const std::size_t columns = reader.get_columns(count, sizeof(typename Descriptors::Scalar));
  Descriptors descriptors(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(columns));
  reader.get(descriptors.data(), static_cast<std::size_t>(descriptors.size()));
  return descriptors;
}

MeasuredFeatures get_features(PlainReader& reader) {
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
    measured.features.descriptors = get_descriptors<features::FloatDescriptors>(reader, count);
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
  PlainWriter writer;
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
  PlainReader reader(bytes);
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
