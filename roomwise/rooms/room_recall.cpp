#include "roomwise/rooms/room_recall.h"

#include <array>

namespace roomwise::rooms {
namespace {

// Every single number of a calibration, in the order in which it is stored.
constexpr std::array kCalibration = {
    &RoomCalibration::temperature,        &RoomCalibration::finely_mean,
    &RoomCalibration::finely_deviation,   &RoomCalibration::coarsely_mean,
    &RoomCalibration::coarsely_deviation, &RoomCalibration::sure_from,
    &RoomCalibration::known_from,         &RoomCalibration::none_below};

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

void write(NumberWriter& writer, const RoomRecall& recall) {
  const RoomMemory& memory = recall.memory;
  const PictureSpace& space = memory.space();
  writer.number(static_cast<std::uint32_t>(space.directions().cols()));
  writer.number(static_cast<std::uint32_t>(memory.places().rows()));
  write_matrix(writer, space.mean());
  write_matrix(writer, space.directions());
  write_matrix(writer, space.deviations());
  write_matrix(writer, memory.places());
  for (const int room : memory.room()) writer.number(static_cast<std::uint32_t>(room));
  for (const int picture : memory.picture()) writer.number(static_cast<std::uint32_t>(picture));
  for (const auto number : kCalibration) writer.real(recall.calibration.*number);
  const std::vector<double>& usual = recall.calibration.usual_of_rooms;
  writer.number(static_cast<std::uint32_t>(usual.size()));
  for (const double value : usual) writer.real(value);
}

Expected<RoomRecall> read_recall(NumberReader& reader, std::size_t rooms, std::size_t features,
                                 std::uint32_t version) {
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
  Eigen::MatrixXf places = read_matrix(reader, rows, directions);
  std::vector<int> room(rows);
  std::vector<int> picture(rows);
  for (int& value : room) value = static_cast<int>(reader.number());
  for (int& value : picture) value = static_cast<int>(reader.number());
  RoomRecall recall;
  for (const auto number : kCalibration) recall.calibration.*number = reader.real_of_64_bits();
  const std::size_t usual = version > 2 ? reader.number() : 0;
  if (usual != 0 && usual != rooms) return fail("not every room has what is usual in it");
  for (std::size_t i = 0; i < usual; ++i) {
    recall.calibration.usual_of_rooms.push_back(reader.real_of_64_bits());
  }
  if (reader.failed()) return fail("it is cut short");
  if (!mean.allFinite() || !axes.allFinite() || !places.allFinite() ||
      !are_deviations(deviations)) {
    return fail("a remembered picture is not finite");
  }
  ROOMWISE_CHECK_OK(recall.calibration.validate());
  int pictures = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (room[i] < 0 || room[i] >= static_cast<int>(rooms) || picture[i] < 0 ||
        picture[i] > pictures) {
      return fail("a remembered picture is of no room");
    }
    if (picture[i] == pictures) ++pictures;
  }
  recall.memory =
      RoomMemory(PictureSpace(std::move(mean), std::move(axes), std::move(deviations)),
                 std::move(places), std::move(room), std::move(picture), static_cast<int>(rooms));
  return recall;
}

}  // namespace roomwise::rooms
