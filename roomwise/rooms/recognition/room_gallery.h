#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/rooms/statistics/pca_space.h"

namespace roomwise::rooms {

// How similar a picture is to those that were learned from.
struct Similarity {
  Eigen::VectorXd of_rooms;    // whitened cosine, to the nearest neighbours in each room; -1 to 1
  double whitened_cosine = 0;  // to the nearest neighbours of all rooms
  double plain_cosine = 0;
};

// Remembers the pictures that rooms were learned from, as embeddings in a PcaSpace, each beside
// variants of it in other light. A room is as similar as its three nearest neighbours are on
// average; a picture is as similar as its most similar variant.
class RoomGallery {
 public:
  static constexpr int kNeighbours = 3;

  RoomGallery() = default;
  // rows: root features, one a row; room[i] of row i, in [0, rooms); picture[i]: whose variant row
  // i is, numbered from 0 without gaps.
  RoomGallery(const Eigen::MatrixXf& rows, std::vector<int> room, std::vector<int> picture,
              int rooms);
  // As it was stored: embeddings instead of features. Throws std::invalid_argument where
  // sizes differ or a number is out of range.
  RoomGallery(PcaSpace space, Eigen::MatrixXf projections, std::vector<int> room,
              std::vector<int> picture, int rooms);

  // With more pictures, without variants, after those that are there. The space stays as it is:
  // what was remembered stays as similar to everything as it was. root_features: one picture a row;
  // room[i] of row i.
  [[nodiscard]] RoomGallery with(const Eigen::MatrixXf& root_features,
                                 std::span<const int> room) const;

  [[nodiscard]] Similarity compare(const Eigen::VectorXf& root_features) const;

  [[nodiscard]] const PcaSpace& space() const { return space_; }
  [[nodiscard]] const Eigen::MatrixXf& projections() const { return projections_; }
  [[nodiscard]] const std::vector<int>& room() const { return room_; }
  [[nodiscard]] const std::vector<int>& picture() const { return picture_; }

 private:
  PcaSpace space_;
  Eigen::MatrixXf projections_;
  Eigen::MatrixXf whitened_;
  std::vector<int> room_;     // of each row
  std::vector<int> picture_;  // of each row
  std::vector<int> room_of_picture_;
  int rooms_ = 0;
};

}  // namespace roomwise::rooms
