#include "roomwise/rooms/recognition/room_classifier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

static_assert(std::endian::native == std::endian::little, "homes go from machine to machine");

constexpr std::string_view kMagic = "RWRC";
constexpr std::uint32_t kVersion = 2;

bool has_duplicates(std::vector<std::string> names) {
  std::ranges::sort(names);
  return std::ranges::adjacent_find(names) != names.end();
}

}  // namespace

Eigen::VectorXf unit_length(std::span<const float> features) {
  const Eigen::Map<const Eigen::VectorXf> values(features.data(),
                                                 static_cast<Eigen::Index>(features.size()));
  const double length = values.cast<double>().norm();
  if (!(length > 0)) return values;
  return (values.cast<double>() / length).cast<float>();
}

RoomClassifier::RoomClassifier(NetworkIdentity network, std::vector<std::string> rooms,
                               SoftmaxRegression regression, RoomRetrieval retrieval)
    : network_(std::move(network)),
      rooms_(std::move(rooms)),
      regression_(std::move(regression)),
      retrieval_(std::move(retrieval)) {
  const auto classes = static_cast<std::size_t>(regression_.biases().size());
  if (rooms_.empty() || rooms_.size() != classes ||
      regression_.weights().rows() != regression_.biases().size()) {
    throw std::invalid_argument("RoomClassifier: not one class a room");
  }
}

Expected<void> RoomClassifier::check(std::span<const float> features) const {
  if (features.size() != feature_size()) {
    return fail(
        "the picture has {} features, but the rooms were learned on {} of the network {}; use "
        "that network, or learn the rooms again",
        features.size(), feature_size(), network_.name);
  }
  if (!std::ranges::all_of(features, [](float value) { return std::isfinite(value); })) {
    return fail("the picture's features are not finite");
  }
  return {};
}

Expected<RoomClassifier> RoomClassifier::with(std::span<const RoomPicture> pictures) const {
  Eigen::MatrixXf rows(pictures.size(), feature_size());
  std::vector<int> rooms;
  for (const RoomPicture& picture : pictures) {
    ROOMWISE_RETURN_IF_ERROR(check(picture.features));
    const auto room = std::ranges::find(rooms_, picture.room);
    if (room == rooms_.end()) return fail("room \"{}\" was not learned", picture.room);
    rows.row(static_cast<Eigen::Index>(rooms.size())) = root_features(picture.features);
    rooms.push_back(static_cast<int>(room - rooms_.begin()));
  }
  RoomClassifier more = *this;
  more.retrieval_.gallery = retrieval_.gallery.with(rows, rooms);
  return more;
}

Expected<Similarity> RoomClassifier::similarity(std::span<const float> features) const {
  ROOMWISE_RETURN_IF_ERROR(check(features));
  return retrieval_.gallery.compare(root_features(features));
}

Expected<PictureEvidence> RoomClassifier::evidence(std::span<const float> features) const {
  ROOMWISE_TRY(const Similarity similarity, this->similarity(features));
  const RoomCalibration& calibration = retrieval_.calibration;
  return PictureEvidence{
      model().probabilities(
          similarity, regression_.probabilities(unit_length(features)).cast<double>(), calibration),
      model().familiarity(familiarity_numbers(similarity, calibration))};
}

Expected<std::vector<RoomScore>> RoomClassifier::scores(std::span<const float> features) const {
  ROOMWISE_RETURN_IF_ERROR(check(features));
  const Eigen::VectorXf probabilities = regression_.probabilities(unit_length(features));
  std::vector<RoomScore> scores;
  for (std::size_t i = 0; i < rooms_.size(); ++i) {
    scores.push_back({rooms_[i], static_cast<double>(probabilities[static_cast<Eigen::Index>(i)])});
  }
  std::ranges::stable_sort(scores, std::ranges::greater{}, &RoomScore::score);
  return scores;
}

Bytes RoomClassifier::to_bytes() const {
  PlainWriter writer;
  writer.put(kMagic.data(), kMagic.size());
  writer.put(kVersion);
  writer.put_text(network_.name);
  writer.put_text(network_.fingerprint);
  writer.put(static_cast<std::uint32_t>(rooms_.size()));
  writer.put(static_cast<std::uint32_t>(feature_size()));
  for (Eigen::Index i = 0; i < regression_.biases().size(); ++i) {
    writer.put_text(rooms_[static_cast<std::size_t>(i)]);
    writer.put(regression_.biases()[i]);
    const Eigen::VectorXf weights = regression_.weights().row(i);
    writer.put(weights.data(), feature_size());
  }
  write(writer, retrieval_);
  return writer.take();
}

Expected<RoomClassifier> RoomClassifier::from_bytes(std::span<const std::uint8_t> bytes) {
  const auto damaged = [](std::string_view what) {
    return fail("the room classifier is damaged: {}; learn the rooms again", what);
  };
  PlainReader reader(bytes);
  if (reader.get_text(kMagic.size()) != kMagic) return damaged("it does not begin with RWRC");
  const auto version = reader.get<std::uint32_t>();
  if (version != kVersion) {
    return fail("the room classifier has version {}, this program reads {}; learn the rooms again",
                version, kVersion);
  }
  NetworkIdentity network;
  network.name = reader.get_text();
  network.fingerprint = reader.get_text();
  const std::size_t rooms = reader.get<std::uint32_t>();
  const std::size_t features = reader.get<std::uint32_t>();
  // Every room takes its name's length, bias and weights; asked before any memory is taken.
  if (reader.is_short() || rooms == 0 || features == 0 ||
      reader.left() / (8 + 4 * features) < rooms) {
    return damaged("it is cut short");
  }
  std::vector<std::string> names;
  std::vector<float> row(features);
  Eigen::MatrixXf weights(rooms, features);
  Eigen::VectorXf biases(rooms);
  for (Eigen::Index i = 0; i < biases.size(); ++i) {
    names.push_back(reader.get_text());
    biases[i] = reader.get<float>();
    reader.get(row.data(), row.size());
    weights.row(i) = Eigen::Map<const Eigen::RowVectorXf>(row.data(), weights.cols());
  }
  if (reader.is_short()) return damaged("it is cut short");
  auto retrieval = read_retrieval(reader, rooms, features);
  if (!retrieval) return damaged(retrieval.error().message);
  if (reader.left() != 0) return damaged("something follows its end");
  if (!weights.allFinite() || !biases.allFinite()) return damaged("a weight is not finite");
  if (has_duplicates(names)) return damaged("it names a room twice");
  return RoomClassifier(std::move(network), std::move(names),
                        SoftmaxRegression(std::move(weights), std::move(biases)),
                        *std::move(retrieval));
}

}  // namespace roomwise::rooms
