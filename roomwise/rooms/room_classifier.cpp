#include "roomwise/rooms/room_classifier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

constexpr std::string_view kMagic = "RWRC";
constexpr std::uint32_t kVersion = 1;

class Writer {
 public:
  void raw(std::string_view text) { bytes_.insert(bytes_.end(), text.begin(), text.end()); }
  void number(std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  }
  void real(float value) { number(std::bit_cast<std::uint32_t>(value)); }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Reads what Writer wrote. Reading past the end gives zeros and marks the reader as failed, so that
// a caller may check once.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

  std::string raw(std::size_t size) {
    if (size > rest_.size()) {
      failed_ = true;
      size = 0;
    }
    const std::string text(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(size));
    rest_ = rest_.subspan(size);
    return text;
  }
  std::uint32_t number() {
    if (rest_.size() < 4) {
      failed_ = true;
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{rest_[i]} << (8 * i);
    rest_ = rest_.subspan(4);
    return value;
  }
  float real() { return std::bit_cast<float>(number()); }
  std::string text() { return raw(number()); }

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
  bool failed_ = false;
};

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
                               SoftmaxRegression regression)
    : network_(std::move(network)), rooms_(std::move(rooms)), regression_(std::move(regression)) {
  const auto classes = static_cast<std::size_t>(regression_.biases().size());
  if (rooms_.empty() || rooms_.size() != classes ||
      regression_.weights().rows() != regression_.biases().size()) {
    throw std::invalid_argument("RoomClassifier: not one class a room");
  }
}

Expected<std::vector<RoomScore>> RoomClassifier::scores(std::span<const float> features) const {
  if (features.size() != feature_size()) {
    return fail(
        "the picture has {} features, but the rooms were learned on {} of the network {}; use "
        "that network, or learn the rooms again",
        features.size(), feature_size(), network_.name);
  }
  if (!std::ranges::all_of(features, [](float value) { return std::isfinite(value); })) {
    return fail("the picture's features are not finite");
  }
  const Eigen::VectorXf probabilities = regression_.probabilities(unit_length(features));
  std::vector<RoomScore> scores;
  for (std::size_t i = 0; i < rooms_.size(); ++i) {
    scores.push_back({rooms_[i], static_cast<double>(probabilities[static_cast<Eigen::Index>(i)])});
  }
  std::ranges::stable_sort(scores, std::ranges::greater{}, &RoomScore::score);
  return scores;
}

Bytes RoomClassifier::to_bytes() const {
  Writer writer;
  writer.raw(kMagic);
  writer.number(kVersion);
  writer.text(network_.name);
  writer.text(network_.fingerprint);
  writer.number(static_cast<std::uint32_t>(rooms_.size()));
  writer.number(static_cast<std::uint32_t>(feature_size()));
  for (Eigen::Index i = 0; i < regression_.biases().size(); ++i) {
    writer.text(rooms_[static_cast<std::size_t>(i)]);
    writer.real(regression_.biases()[i]);
    for (Eigen::Index j = 0; j < regression_.weights().cols(); ++j) {
      writer.real(regression_.weights()(i, j));
    }
  }
  return writer.take();
}

Expected<RoomClassifier> RoomClassifier::from_bytes(std::span<const std::uint8_t> bytes) {
  const auto damaged = [](std::string_view what) {
    return fail("the room classifier is damaged: {}; learn the rooms again", what);
  };
  Reader reader(bytes);
  if (reader.raw(kMagic.size()) != kMagic) return damaged("it does not begin with RWRC");
  if (const std::uint32_t version = reader.number(); version != kVersion) {
    return fail("the room classifier has version {}, this program reads {}; learn the rooms again",
                version, kVersion);
  }
  NetworkIdentity network;
  network.name = reader.text();
  network.fingerprint = reader.text();
  const std::size_t rooms = reader.number();
  const std::size_t features = reader.number();
  // Every room takes its name's length, bias and weights; asked before any memory is taken.
  if (reader.failed() || rooms == 0 || features == 0 ||
      reader.left() / (8 + 4 * features) < rooms) {
    return damaged("it is cut short");
  }
  std::vector<std::string> names;
  Eigen::MatrixXf weights(rooms, features);
  Eigen::VectorXf biases(rooms);
  for (Eigen::Index i = 0; i < biases.size(); ++i) {
    names.push_back(reader.text());
    biases[i] = reader.real();
    for (Eigen::Index j = 0; j < weights.cols(); ++j) weights(i, j) = reader.real();
  }
  if (reader.failed()) return damaged("it is cut short");
  if (reader.left() != 0) return damaged("something follows its end");
  if (!weights.allFinite() || !biases.allFinite()) return damaged("a weight is not finite");
  if (has_duplicates(names)) return damaged("it names a room twice");
  return RoomClassifier(std::move(network), std::move(names),
                        SoftmaxRegression(std::move(weights), std::move(biases)));
}

}  // namespace roomwise::rooms
