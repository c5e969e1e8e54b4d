#include "roomwise/rooms/recognition/room_gallery.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

constexpr float kMinSimilar = -1;

// The mean of the largest `most` values.
double mean_of_largest(std::vector<float> values, int most) {
  if (values.empty()) return kMinSimilar;
  const auto count = std::min(values.size(), static_cast<std::size_t>(most));
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  std::ranges::partial_sort(values, end, std::greater());
  return std::accumulate(values.begin(), end, 0.0) / static_cast<double>(count);
}

}  // namespace

RoomGallery::RoomGallery(const Eigen::MatrixXf& rows, std::vector<int> room,
                         std::vector<int> picture, int rooms) {
  PcaSpace space = PcaSpace::fit(rows);
  Eigen::MatrixXf projections = space.projections(rows);
  *this = RoomGallery(std::move(space), std::move(projections), std::move(room), std::move(picture),
                      rooms);
}

RoomGallery::RoomGallery(PcaSpace space, Eigen::MatrixXf projections, std::vector<int> room,
                         std::vector<int> picture, int rooms)
    : space_(std::move(space)),
      projections_(std::move(projections)),
      whitened_(space_.whitened(projections_)),
      room_(std::move(room)),
      picture_(std::move(picture)),
      rooms_(rooms) {
  const auto count = static_cast<std::size_t>(projections_.rows());
  if (room_.size() != count || picture_.size() != count ||
      projections_.cols() != space_.directions().cols()) {
    throw std::invalid_argument("RoomGallery: sizes differ");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto pictures = static_cast<int>(room_of_picture_.size());
    if (room_[i] < 0 || room_[i] >= rooms || picture_[i] < 0 || picture_[i] > pictures) {
      throw std::invalid_argument("RoomGallery: a number is out of range");
    }
    if (picture_[i] == pictures) room_of_picture_.push_back(room_[i]);
  }
}

RoomGallery RoomGallery::with(const Eigen::MatrixXf& root_features,
                              std::span<const int> room) const {
  if (root_features.rows() == 0) return *this;
  Eigen::MatrixXf projections(projections_.rows() + root_features.rows(), projections_.cols());
  projections << projections_, space_.projections(root_features);
  std::vector<int> rooms = room_;
  rooms.insert(rooms.end(), room.begin(), room.end());
  std::vector<int> pictures = picture_;
  auto picture = static_cast<int>(room_of_picture_.size());
  for (std::size_t i = 0; i < room.size(); ++i) pictures.push_back(picture++);
  return {space_, std::move(projections), std::move(rooms), std::move(pictures), rooms_};
}

Similarity RoomGallery::compare(const Eigen::VectorXf& root_features) const {
  const Eigen::MatrixXf projection = space_.projections(root_features.transpose());
  const Eigen::VectorXf whitened = whitened_ * space_.whitened(projection).transpose();
  const Eigen::VectorXf plain = space_.plain_cosine(root_features, projections_);
  // Of each picture, that of its most similar variant.
  std::vector<float> whitened_of(room_of_picture_.size(), kMinSimilar);
  std::vector<float> plain_of(room_of_picture_.size(), kMinSimilar);
  for (std::size_t i = 0; i < picture_.size(); ++i) {
    const auto picture = static_cast<std::size_t>(picture_[i]);
    const auto row = static_cast<Eigen::Index>(i);
    whitened_of[picture] = std::max(whitened_of[picture], whitened[row]);
    plain_of[picture] = std::max(plain_of[picture], plain[row]);
  }
  Similarity similarity;
  similarity.whitened_cosine = mean_of_largest(whitened_of, kNeighbours);
  similarity.plain_cosine = mean_of_largest(plain_of, kNeighbours);
  std::vector<std::vector<float>> of_rooms(static_cast<std::size_t>(rooms_));
  for (std::size_t i = 0; i < whitened_of.size(); ++i) {
    of_rooms[static_cast<std::size_t>(room_of_picture_[i])].push_back(whitened_of[i]);
  }
  similarity.of_rooms.resize(rooms_);
  for (std::size_t room = 0; room < of_rooms.size(); ++room) {
    similarity.of_rooms[static_cast<Eigen::Index>(room)] =
        mean_of_largest(std::move(of_rooms[room]), kNeighbours);
  }
  return similarity;
}

}  // namespace roomwise::rooms
