#include "roomwise/rooms/statistics/principal_components.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roomwise::rooms {
namespace {

// Components of less variance than this part of the first one's are rounding errors.
constexpr double kMinVarianceRatio = 1e-6;

Eigen::MatrixXf thinned(const Eigen::MatrixXf& rows, Eigen::Index max_rows) {
  if (rows.rows() <= max_rows) return rows;
  Eigen::MatrixXf some(max_rows, rows.cols());
  for (Eigen::Index i = 0; i < max_rows; ++i) some.row(i) = rows.row(i * rows.rows() / max_rows);
  return some;
}

}  // namespace

PrincipalComponents principal_components(const Eigen::MatrixXf& rows,
                                         const ComponentLimits& limits) {
  if (rows.rows() < 1 || limits.rows < 1)
    throw std::invalid_argument("principal_components: no rows");
  const Eigen::MatrixXf some = thinned(rows, limits.rows);
  const auto count = static_cast<double>(some.rows());
  PrincipalComponents found;
  found.mean = (some.cast<double>().colwise().sum().transpose() / count).cast<float>();
  const Eigen::MatrixXf centred = some.transpose().colwise() - found.mean;  // a row a column
  // There are fewer rows than columns, as a rule: the components are found from the rows' inner
  // products, of which there are fewer. One by one, since how a product of matrices is grouped, and
  // so rounded, hangs on the processor's caches.
  Eigen::MatrixXd products(some.rows(), some.rows());
  for (Eigen::Index i = 0; i < products.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j)
      products(i, j) = products(j, i) = centred.col(i).dot(centred.col(j));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
  const Eigen::VectorXd& values = solver.eigenvalues();  // ascending
  const double largest = std::max(values[values.size() - 1], 0.0);
  Eigen::Index kept = 0;
  while (kept < std::min({values.size(), some.cols(), limits.directions}) &&
         values[values.size() - 1 - kept] > kMinVarianceRatio * largest && largest > 0) {
    ++kept;
  }
  found.directions.resize(some.cols(), kept);
  found.deviations.resize(kept);
  for (Eigen::Index i = 0; i < kept; ++i) {
    const Eigen::Index from = values.size() - 1 - i;
    const Eigen::VectorXd weights = solver.eigenvectors().col(from) / std::sqrt(values[from]);
    found.directions.col(i) = (centred * weights.cast<float>()).normalized();
    found.deviations[i] = static_cast<float>(std::sqrt(values[from] / count));
  }
  if (kept < some.cols()) {
    const double remaining = values.head(values.size() - kept).cwiseMax(0).sum();
    found.remaining_variance = remaining / count / static_cast<double>(some.cols() - kept);
  }
  return found;
}

}  // namespace roomwise::rooms
