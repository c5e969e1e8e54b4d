#include "roomwise/rooms/picture_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

// Components of less variance than this part of the first one's are rounding errors.
constexpr double kLeastVarianceRatio = 1e-6;
// What is added to every direction's variance before whitening, in parts of the mean one.
constexpr float kShrinkage = 3;

// At most kMostFitted rows, spread evenly.
Eigen::MatrixXf thinned(const Eigen::MatrixXf& rows) {
  if (rows.rows() <= PictureSpace::kMostFitted) return rows;
  Eigen::MatrixXf some(PictureSpace::kMostFitted, rows.cols());
  for (Eigen::Index i = 0; i < some.rows(); ++i) {
    some.row(i) = rows.row(i * rows.rows() / some.rows());
  }
  return some;
}

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

PictureSpace::PictureSpace(Eigen::VectorXf mean, Eigen::MatrixXf directions,
                           Eigen::VectorXf deviations)
    : mean_(std::move(mean)),
      directions_(std::move(directions)),
      deviations_(std::move(deviations)) {
  if (directions_.rows() != mean_.size() || directions_.cols() != deviations_.size()) {
    throw std::invalid_argument("PictureSpace: sizes differ");
  }
}

PictureSpace PictureSpace::fit(const Eigen::MatrixXf& pictures) {
  if (pictures.rows() == 0) throw std::invalid_argument("PictureSpace: no pictures");
  const Eigen::MatrixXf some = thinned(pictures);
  const auto count = static_cast<double>(some.rows());
  const Eigen::VectorXf mean =
      (some.cast<double>().colwise().sum().transpose() / count).cast<float>();
  const Eigen::MatrixXf centred = some.rowwise() - mean.transpose();
  // There are fewer pictures than features: the components are found from the pictures' inner
  // products, of which there are fewer.
  const Eigen::MatrixXd products = (centred * centred.transpose()).cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
  const Eigen::VectorXd& values = solver.eigenvalues();  // ascending
  const double largest = std::max(values[values.size() - 1], 0.0);
  Eigen::Index kept = 0;
  while (kept < std::min(values.size(), kMostDirections) &&
         values[values.size() - 1 - kept] > kLeastVarianceRatio * largest && largest > 0) {
    ++kept;
  }
  Eigen::MatrixXf directions(some.cols(), kept);
  Eigen::VectorXf deviations(kept);
  for (Eigen::Index i = 0; i < kept; ++i) {
    const Eigen::Index from = values.size() - 1 - i;
    const Eigen::VectorXd weights = solver.eigenvectors().col(from) / std::sqrt(values[from]);
    directions.col(i) = centred.transpose() * weights.cast<float>();
    deviations[i] = static_cast<float>(std::sqrt(values[from] / count));
  }
  return PictureSpace(mean, std::move(directions), std::move(deviations));
}

Eigen::MatrixXf PictureSpace::places(const Eigen::MatrixXf& pictures) const {
  return (pictures.rowwise() - mean_.transpose()) * directions_;
}

Eigen::MatrixXf PictureSpace::whitened(const Eigen::MatrixXf& places) const {
  if (deviations_.size() == 0) return places;
  const Eigen::ArrayXf variances = deviations_.array().square();
  const Eigen::ArrayXf scales = (variances + kShrinkage * variances.mean()).rsqrt();
  Eigen::MatrixXf white = places * scales.matrix().asDiagonal();
  for (Eigen::Index i = 0; i < white.rows(); ++i) {
    if (const float length = white.row(i).norm(); length > 0) white.row(i) /= length;
  }
  return white;
}

Eigen::VectorXf PictureSpace::coarsely(const Eigen::VectorXf& picture,
                                       const Eigen::MatrixXf& places) const {
  // Of a picture at place c these directions say mean + directions c.
  const float at_mean = picture.dot(mean_);
  return (places * (directions_.transpose() * picture)).array() + at_mean;
}

}  // namespace roomwise::rooms
