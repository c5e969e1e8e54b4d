#include "roomwise/rooms/statistics/pca_space.h"

#include <cmath>
#include <stdexcept>

#include "roomwise/rooms/statistics/principal_components.h"

namespace roomwise::rooms {
namespace {

// What is added to every direction's variance before whitening, in parts of the mean one.
constexpr float kShrinkage = 3;

}  // namespace

Eigen::VectorXf root_features(std::span<const float> features) {
  const Eigen::Map<const Eigen::VectorXf> values(features.data(),
                                                 static_cast<Eigen::Index>(features.size()));
  // Roots of what is scaled to length 1 and roots scaled to length 1 are the same direction.
  Eigen::VectorXd roots = values.cast<double>().cwiseMax(0).cwiseSqrt();
  const double length = roots.norm();
  if (length > 0) roots /= length;
  return roots.cast<float>();
}

PcaSpace::PcaSpace(Eigen::VectorXf mean, Eigen::MatrixXf directions, Eigen::VectorXf deviations)
    : mean_(std::move(mean)),
      directions_(std::move(directions)),
      deviations_(std::move(deviations)) {
  if (directions_.rows() != mean_.size() || directions_.cols() != deviations_.size()) {
    throw std::invalid_argument("PcaSpace: sizes differ");
  }
}

PcaSpace PcaSpace::fit(const Eigen::MatrixXf& pictures) {
  PrincipalComponents found = principal_components(pictures, {kMaxFitted, kMaxDirections});
  return PcaSpace(std::move(found.mean), std::move(found.directions), std::move(found.deviations));
}

Eigen::MatrixXf PcaSpace::projections(const Eigen::MatrixXf& pictures) const {
  return (pictures.rowwise() - mean_.transpose()) * directions_;
}

Eigen::MatrixXf PcaSpace::whitened(const Eigen::MatrixXf& projections) const {
  if (deviations_.size() == 0) return projections;
  const Eigen::ArrayXf variances = deviations_.array().square();
  const Eigen::ArrayXf scales = (variances + kShrinkage * variances.mean()).rsqrt();
  Eigen::MatrixXf white = projections * scales.matrix().asDiagonal();
  for (Eigen::Index i = 0; i < white.rows(); ++i) {
    if (const float length = white.row(i).norm(); length > 0) white.row(i) /= length;
  }
  return white;
}

Eigen::VectorXf PcaSpace::plain_cosine(const Eigen::VectorXf& picture,
                                       const Eigen::MatrixXf& projections) const {
  // Of a picture with projections c these directions say mean + directions c.
  const float at_mean = picture.dot(mean_);
  return (projections * (directions_.transpose() * picture)).array() + at_mean;
}

}  // namespace roomwise::rooms
