#include "roomwise/rooms/recognition/room_retrieval.h"

#include <array>

namespace roomwise::rooms {
namespace {

// Every single number of a calibration, in the order in which it is stored.
constexpr std::array kCalibration = {
    &RoomCalibration::temperature, &RoomCalibration::whitened_cosine_mean,
    &RoomCalibration::whitened_cosine_deviation, &RoomCalibration::plain_cosine_mean,
    &RoomCalibration::plain_cosine_deviation};

// Column by column.
void write_matrix(PlainWriter& writer, const Eigen::MatrixXf& matrix) {
  writer.put(matrix.data(), static_cast<std::size_t>(matrix.size()));
}

Eigen::MatrixXf read_matrix(PlainReader& reader, std::size_t rows, std::size_t columns) {
  Eigen::MatrixXf matrix(rows, columns);
  reader.get(matrix.data(), rows * columns);
  return matrix;
}

bool are_deviations(const Eigen::VectorXf& values) {
  return values.allFinite() && (values.array() > 0).all();
}

}  // namespace

void write(PlainWriter& writer, const RoomRetrieval& retrieval) {
  const RoomGallery& gallery = retrieval.gallery;
  const PcaSpace& space = gallery.space();
  writer.put(static_cast<std::uint32_t>(space.directions().cols()));
  writer.put(static_cast<std::uint32_t>(gallery.projections().rows()));
  write_matrix(writer, space.mean());
  write_matrix(writer, space.directions());
  write_matrix(writer, space.deviations());
  write_matrix(writer, gallery.projections());
  writer.put(gallery.room().data(), gallery.room().size());
  writer.put(gallery.picture().data(), gallery.picture().size());
  for (const auto number : kCalibration) writer.put(retrieval.calibration.*number);
}

Expected<RoomRetrieval> read_retrieval(PlainReader& reader, std::size_t rooms,
                                       std::size_t features) {
  const std::uint64_t directions = reader.get<std::uint32_t>();
  const std::uint64_t rows = reader.get<std::uint32_t>();
  // Asked before any memory is taken. Every factor is below 2^32.
  const std::uint64_t left = reader.left() / 4;
  if (reader.is_short() || rows == 0 || directions > left || rows > left ||
      features > left / (directions + 1) || rows > left / (directions + 2)) {
    return fail("it is cut short");
  }
  Eigen::VectorXf mean = read_matrix(reader, features, 1);
  Eigen::MatrixXf axes = read_matrix(reader, features, directions);
  Eigen::VectorXf deviations = read_matrix(reader, directions, 1);
  Eigen::MatrixXf projections = read_matrix(reader, rows, directions);
  std::vector<int> room(rows);
  std::vector<int> picture(rows);
  reader.get(room.data(), room.size());
  reader.get(picture.data(), picture.size());
  RoomRetrieval retrieval;
  for (const auto number : kCalibration) retrieval.calibration.*number = reader.get<double>();
  if (reader.is_short()) return fail("it is cut short");
  if (!mean.allFinite() || !axes.allFinite() || !projections.allFinite() ||
      !are_deviations(deviations)) {
    return fail("a remembered picture is not finite");
  }
  ROOMWISE_RETURN_IF_ERROR(retrieval.calibration.validate());
  int pictures = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (room[i] < 0 || room[i] >= static_cast<int>(rooms) || picture[i] < 0 ||
        picture[i] > pictures) {
      return fail("a remembered picture is of no room");
    }
    if (picture[i] == pictures) ++pictures;
  }
  retrieval.gallery = RoomGallery(PcaSpace(std::move(mean), std::move(axes), std::move(deviations)),
                                  std::move(projections), std::move(room), std::move(picture),
                                  static_cast<int>(rooms));
  return retrieval;
}

}  // namespace roomwise::rooms
