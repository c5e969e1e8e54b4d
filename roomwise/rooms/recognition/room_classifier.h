#pragma once

#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/rooms/recognition/room_model.h"
#include "roomwise/rooms/recognition/room_retrieval.h"
#include "roomwise/rooms/recognition/two_frame_rule.h"
#include "roomwise/rooms/statistics/softmax_regression.h"

namespace roomwise::rooms {

// The network whose features a classifier was learned on; the features of another mean nothing to
// it.
struct NetworkIdentity {
  std::string name;         // for people
  std::string fingerprint;  // SHA-256 of the weights

  friend bool operator==(const NetworkIdentity&, const NetworkIdentity&) = default;
};

// A picture's features scaled to length 1, so that a bright or busy picture counts no more than
// another; zero features stay zero.
[[nodiscard]] Eigen::VectorXf unit_length(std::span<const float> features);

// A picture of a room, as a network sees it.
struct RoomPicture {
  std::vector<float> features;
  std::string room;
};

// What one picture says about the room, without any other.
struct PictureEvidence {
  Eigen::VectorXd probabilities;  // of each room, every room alike beforehand; add up to 1
  double familiarity = 0;         // log odds that it shows one of these rooms
};

// Names the room that a picture shows from the network's features of it, in two ways: the paper's,
// a softmax regression on the features scaled to unit length; and by that together with how similar
// it is to the pictures that were learned from (RoomRetrieval, RoomModel).
class RoomClassifier {
 public:
  // One room a class of the regression, in its order. Throws std::invalid_argument where their
  // numbers differ.
  RoomClassifier(NetworkIdentity network, std::vector<std::string> rooms,
                 SoftmaxRegression regression, RoomRetrieval retrieval);

  // What the picture says, rooms in the order of rooms(). Fails where the features are not of
  // feature_size() or not finite.
  [[nodiscard]] Expected<PictureEvidence> evidence(std::span<const float> features) const;
  // How similar it is to the pictures that were learned from. Fails likewise.
  [[nodiscard]] Expected<Similarity> similarity(std::span<const float> features) const;
  // The regression's probability of every room, best first (equal ones in the order of rooms()).
  // Fails as evidence() does.
  [[nodiscard]] Expected<std::vector<RoomScore>> scores(std::span<const float> features) const;

  // With more pictures to compare with (RoomGallery::with). The regression, and the calibration,
  // which says what a similarity means, stay as they were learned. Fails where features are not as
  // evidence() takes them, or a room is none of rooms().
  [[nodiscard]] Expected<RoomClassifier> with(std::span<const RoomPicture> pictures) const;

  [[nodiscard]] const NetworkIdentity& network() const { return network_; }
  // What decides, for its network.
  [[nodiscard]] const RoomModel& model() const { return RoomModel::of(network_.name); }
  [[nodiscard]] const std::vector<std::string>& rooms() const { return rooms_; }
  [[nodiscard]] const SoftmaxRegression& regression() const { return regression_; }
  [[nodiscard]] const RoomRetrieval& retrieval() const { return retrieval_; }
  [[nodiscard]] std::size_t feature_size() const {
    return static_cast<std::size_t>(regression_.weights().cols());
  }

  // The form in which a home file keeps it: "RWRC", version 2, then little-endian counts, texts and
  // floats. Reading fails on anything else: another version, a cut or longer text, a room twice, a
  // value that is not finite or out of range.
  [[nodiscard]] Bytes to_bytes() const;
  [[nodiscard]] static Expected<RoomClassifier> from_bytes(std::span<const std::uint8_t> bytes);

 private:
  [[nodiscard]] Expected<void> check(std::span<const float> features) const;

  NetworkIdentity network_;
  std::vector<std::string> rooms_;
  SoftmaxRegression regression_;
  RoomRetrieval retrieval_;
};

}  // namespace roomwise::rooms
