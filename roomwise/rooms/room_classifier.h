#pragma once

#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/rooms/softmax_regression.h"
#include "roomwise/rooms/two_frame_rule.h"

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

// Names the room that a picture shows from the network's features of it: a softmax regression on
// the features scaled to unit length.
class RoomClassifier {
 public:
  // One room a class of the regression, in its order. Throws std::invalid_argument where their
  // numbers differ.
  RoomClassifier(NetworkIdentity network, std::vector<std::string> rooms,
                 SoftmaxRegression regression);

  // Every room with its probability, best first (equal ones in the order of rooms()). Fails where
  // the features are not of feature_size() or not finite.
  [[nodiscard]] Expected<std::vector<RoomScore>> scores(std::span<const float> features) const;

  [[nodiscard]] const NetworkIdentity& network() const { return network_; }
  [[nodiscard]] const std::vector<std::string>& rooms() const { return rooms_; }
  [[nodiscard]] const SoftmaxRegression& regression() const { return regression_; }
  [[nodiscard]] std::size_t feature_size() const {
    return static_cast<std::size_t>(regression_.weights().cols());
  }

  // The form in which a home file keeps it: "RWRC", version 1, then little-endian counts, texts and
  // 32-bit floats. Reading fails on anything else: another version, a cut or longer text, a room
  // twice, a value that is not finite.
  [[nodiscard]] Bytes to_bytes() const;
  [[nodiscard]] static Expected<RoomClassifier> from_bytes(std::span<const std::uint8_t> bytes);

 private:
  NetworkIdentity network_;
  std::vector<std::string> rooms_;
  SoftmaxRegression regression_;
};

}  // namespace roomwise::rooms
