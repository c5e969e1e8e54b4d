#pragma once

#include <Eigen/Core>
#include <span>

namespace roomwise::rooms {

// A network's features as they are compared: scaled to length 1, square roots taken (the inner
// product of two is then Bhattacharyya's coefficient; Arandjelovic and Zisserman 2012 use it for
// descriptors), scaled again. Values below 0 count as 0; features of zeros stay zeros.
[[nodiscard]] Eigen::VectorXf root_features(std::span<const float> features);

// The directions in which the pictures of one home differ from each other: their principal
// components, most important first. Within them two pictures have two cosine similarities:
//
//  - plain_cosine(): of whole pictures. Tells pictures of this home from those of others.
//  - whitened(): in what tells pictures of this home apart. All directions count about alike,
//    however little of the picture they are. Tells rooms apart, by day and by night.
class PcaSpace {
 public:
  // Of at most so many pictures the components are found; more are thinned out evenly.
  static constexpr Eigen::Index kMaxFitted = 600;
  static constexpr Eigen::Index kMaxDirections = 256;

  PcaSpace() = default;
  // pictures: root features, one a row, at least one. Deterministic.
  [[nodiscard]] static PcaSpace fit(const Eigen::MatrixXf& pictures);
  // As it was stored. mean: features; directions: features x directions, one of length 1 a column;
  // deviations: of each direction, the root of its variance. Throws std::invalid_argument where
  // sizes differ.
  PcaSpace(Eigen::VectorXf mean, Eigen::MatrixXf directions, Eigen::VectorXf deviations);

  // Where a picture lies along each direction. pictures: root features, one a row.
  [[nodiscard]] Eigen::MatrixXf projections(const Eigen::MatrixXf& pictures) const;
  // The same with every direction counting alike, each row scaled to length 1: the inner
  // product of two is their whitened cosine similarity, -1 to 1. A direction of little variance,
  // which few pictures show, counts less: a mean one's variance is added three times.
  [[nodiscard]] Eigen::MatrixXf whitened(const Eigen::MatrixXf& projections) const;
  // The cosine similarity of a picture to the one of each row of `projections`: the inner product
  // with what these directions say of it, 0 to 1 or a little outside.
  [[nodiscard]] Eigen::VectorXf plain_cosine(const Eigen::VectorXf& picture,
                                             const Eigen::MatrixXf& projections) const;

  [[nodiscard]] const Eigen::VectorXf& mean() const { return mean_; }
  [[nodiscard]] const Eigen::MatrixXf& directions() const { return directions_; }
  [[nodiscard]] const Eigen::VectorXf& deviations() const { return deviations_; }

 private:
  Eigen::VectorXf mean_;
  Eigen::MatrixXf directions_;
  Eigen::VectorXf deviations_;
};

}  // namespace roomwise::rooms
