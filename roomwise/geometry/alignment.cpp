#include "roomwise/geometry/alignment.h"

#include <Eigen/SVD>

namespace roomwise::geometry {

Expected<RigidTransform> align_points(std::span<const Eigen::Vector3d> from,
                                      std::span<const Eigen::Vector3d> to) {
  if (from.size() != to.size()) {
    return fail("cannot align {} points with {}; there must be as many", from.size(), to.size());
  }
  if (from.size() < 3) return fail("cannot align {} points; at least 3 are needed", from.size());

  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i];
    to_mean += to[i];
  }
  from_mean /= static_cast<double>(from.size());
  to_mean /= static_cast<double>(from.size());

  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  constexpr double kDegenerate = 1e-12;
  if (!(svd.singularValues()(1) > kDegenerate * svd.singularValues()(0))) {
    return fail(
        "cannot align points that lie on one line: the rotation about it is not determined");
  }
  Eigen::Matrix3d handedness = Eigen::Matrix3d::Identity();
  handedness(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d rotation = svd.matrixU() * handedness * svd.matrixV().transpose();
  return RigidTransform::from_matrix(rotation, to_mean - rotation * from_mean);
}

}  // namespace roomwise::geometry
