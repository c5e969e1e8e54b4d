#include "roomwise/rooms/recognition/room_retrieval.h"

#include <array>

namespace roomwise::rooms {
namespace {

// Every single number of a calibration, in the order in which it is stored.
constexpr std::array kCalibration = {&RoomCalibration::temperature,
                                     &RoomCalibration::whitened_cosine_mean,
                                     &RoomCalibration::whitened_cosine_deviation,
                                     &RoomCalibration::plain_cosine_mean,
                                     &RoomCalibration::plain_cosine_deviation,
                                     &RoomCalibration::confidence_threshold,
                                     &RoomCalibration::known_threshold,
                                     &RoomCalibration::reject_threshold};

void write_matrix(NumberWriter& writer, const Eigen::MatrixXf& matrix) {
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) writer.real(matrix(i, j));
  }
}

Eigen::MatrixXf read_matrix(NumberReader& reader, std::size_t rows, std::size_t columns) {
  Eigen::MatrixXf matrix(rows, columns);
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix(i, j) = reader.real();
  }
  return matrix;
}

bool are_deviations(const Eigen::VectorXf& values) {
  return values.allFinite() && (values.array() > 0).all();
}

}  // namespace

void write(NumberWriter& writer, const RoomRetrieval& retrieval) {
  const RoomGallery& memory = retrieval.memory;
  const PcaSpace& space = memory.space();
  writer.number(static_cast<std::uint32_t>(space.directions().cols()));
  writer.number(static_cast<std::uint32_t>(memory.projections().rows()));
  write_matrix(writer, space.mean());
  write_matrix(writer, space.directions());
  write_matrix(writer, space.deviations());
  write_matrix(writer, memory.projections());
  for (const int room : memory.room()) writer.number(static_cast<std::uint32_t>(room));
  for (const int picture : memory.picture()) writer.number(static_cast<std::uint32_t>(picture));
  for (const auto number : kCalibration) writer.real(retrieval.calibration.*number);
  const std::vector<double>& usual = retrieval.calibration.room_score_means;
  writer.number(static_cast<std::uint32_t>(usual.size()));
  for (const double value : usual) writer.real(value);
}

Expected<RoomRetrieval> read_retrieval(NumberReader& reader, std::size_t rooms,
                                       std::size_t features, std::uint32_t version) {
  const std::uint64_t directions = reader.number();
  const std::uint64_t rows = reader.number();
  // Asked before any memory is taken. Every factor is below 2^32.
  const std::uint64_t left = reader.left() / 4;
  if (reader.failed() || rows == 0 || directions > left || rows > left ||
      features > left / (directions + 1) || rows > left / (directions + 2)) {
    return fail("it is cut short");
  }
  Eigen::VectorXf mean = read_matrix(reader, features, 1);
  Eigen::MatrixXf axes = read_matrix(reader, features, directions);
  Eigen::VectorXf deviations = read_matrix(reader, directions, 1);
  Eigen::MatrixXf projections = read_matrix(reader, rows, directions);
  std::vector<int> room(rows);
  std::vector<int> picture(rows);
  for (int& value : room) value = static_cast<int>(reader.number());
  for (int& value : picture) value = static_cast<int>(reader.number());
  RoomRetrieval retrieval;
  for (const auto number : kCalibration) retrieval.calibration.*number = reader.real_of_64_bits();
  const std::size_t usual = version > 2 ? reader.number() : 0;
  if (usual != 0 && usual != rooms) return fail("not every room has what is usual in it");
  for (std::size_t i = 0; i < usual; ++i) {
    retrieval.calibration.room_score_means.push_back(reader.real_of_64_bits());
  }
  if (reader.failed()) return fail("it is cut short");
  if (!mean.allFinite() || !axes.allFinite() || !projections.allFinite() ||
      !are_deviations(deviations)) {
    return fail("a remembered picture is not finite");
  }
  ROOMWISE_CHECK_OK(retrieval.calibration.validate());
  int pictures = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (room[i] < 0 || room[i] >= static_cast<int>(rooms) || picture[i] < 0 ||
        picture[i] > pictures) {
      return fail("a remembered picture is of no room");
    }
    if (picture[i] == pictures) ++pictures;
  }
  retrieval.memory = RoomGallery(PcaSpace(std::move(mean), std::move(axes), std::move(deviations)),
                                 std::move(projections), std::move(room), std::move(picture),
                                 static_cast<int>(rooms));
  return retrieval;
}

}  // namespace roomwise::rooms
