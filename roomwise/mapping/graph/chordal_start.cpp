#include "roomwise/mapping/graph/chordal_start.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>

#include "roomwise/mapping/graph/block_cholesky.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

// Linear equations with a block of 3 x 3 numbers a pose, two right-hand sides of which are solved
// at once: each block of BlockCholesky holds it twice.
class TwinEquations {
 public:
  explicit TwinEquations(const IndexedGraph& graph)
      : graph_(graph), diagonal_(graph.world_from_node.size(), Eigen::Matrix3d::Zero()) {}

  // What an edge adds where its residual is A x_to - B x_from.
  void add(const NumberedEdge& edge, const Eigen::Matrix3d& from_from, const Eigen::Matrix3d& to_to,
           const Eigen::Matrix3d& from_to) {
    diagonal_[edge.from] += from_from;
    diagonal_[edge.to] += to_to;
    if (is_free(edge.from) && is_free(edge.to)) {
      pairs_.emplace_back(place(edge.from), place(edge.to));
      off_diagonal_.push_back(twice(from_to));
    }
  }

  [[nodiscard]] bool factorize() {
    std::vector<Matrix6d> diagonal;
    for (std::size_t node = graph_.fixed_pose_count; node < diagonal_.size(); ++node)
      diagonal.push_back(twice(diagonal_[node]));
    cholesky_.emplace(diagonal.size(), pairs_);
    return cholesky_->factorize(diagonal, off_diagonal_);
  }

  // After factorize() said true: b before and x after, two columns of three numbers a free pose.
  void solve(std::vector<Eigen::Matrix<double, 3, 2>>& columns) const {
    Eigen::VectorXd numbers(6 * static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i)
      numbers.segment<6>(6 * static_cast<Eigen::Index>(i)) = columns[i].reshaped();
    cholesky_->solve(numbers);
    for (std::size_t i = 0; i < columns.size(); ++i)
      columns[i].reshaped() = numbers.segment<6>(6 * static_cast<Eigen::Index>(i));
  }

  [[nodiscard]] bool is_free(std::uint32_t node) const { return node >= graph_.fixed_pose_count; }
  [[nodiscard]] std::uint32_t place(std::uint32_t node) const {
    return node - static_cast<std::uint32_t>(graph_.fixed_pose_count);
  }

 private:
  static Matrix6d twice(const Eigen::Matrix3d& block) {
    Matrix6d both = Matrix6d::Zero();
    both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = block;
    return both;
  }

  const IndexedGraph& graph_;
  std::vector<Eigen::Matrix3d> diagonal_;  // by pose
  std::vector<BlockPair> pairs_;
  std::vector<Matrix6d> off_diagonal_;
  std::optional<BlockCholesky> cholesky_;
};

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return Eigen::Quaterniond(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose())
      .normalized();
}

// Minimises the sum of w |R_to - R_from Z|^2 (Frobenius) over matrices R. Row by row of R, written
// as a column r, an edge's residual is r_to - Z^T r_from.
bool set_turns(const IndexedGraph& graph, std::vector<RigidTransform>& poses) {
  TwinEquations equations(graph);
  const std::size_t free_poses = poses.size() - graph.fixed_pose_count;
  // Rows 0 and 1, and rows 2 and 2 of the matrices.
  std::array<std::vector<Eigen::Matrix<double, 3, 2>>, 2> rows;
  for (auto& pair : rows) pair.assign(free_poses, Eigen::Matrix<double, 3, 2>::Zero());
  const auto add_fixed = [&](std::uint32_t node, const Eigen::Matrix3d& known_rows) {
    if (!equations.is_free(node)) return;
    rows[0][equations.place(node)] += known_rows.leftCols<2>();
    rows[1][equations.place(node)].colwise() += known_rows.col(2);
  };
  for (const NumberedEdge& edge : graph.edges) {
    const double weight = edge.edge->information.bottomRightCorner<3, 3>().trace() / 3;
    const Eigen::Matrix3d turn = edge.edge->from_from_to.rotation.toRotationMatrix();
    const Eigen::Matrix3d same = weight * Eigen::Matrix3d::Identity();
    equations.add(edge, same, same, -weight * turn);
    const auto rows_of = [&](std::uint32_t node) -> Eigen::Matrix3d {
      return poses[node].rotation.toRotationMatrix().transpose();
    };
    if (!equations.is_free(edge.from))
      add_fixed(edge.to, weight * turn.transpose() * rows_of(edge.from));
    if (!equations.is_free(edge.to)) add_fixed(edge.from, weight * turn * rows_of(edge.to));
  }
  if (!equations.factorize()) return false;
  for (auto& pair : rows) equations.solve(pair);
  for (std::size_t i = 0; i < free_poses; ++i) {
    Eigen::Matrix3d matrix;
    matrix << rows[0][i].transpose(), rows[1][i].col(0).transpose();
    if (!matrix.allFinite()) return false;
    poses[graph.fixed_pose_count + i].rotation = nearest_rotation(matrix);
  }
  return true;
}

// Minimises the edges' errors over places, the turns as they are: of an edge, t_to - t_from is
// measured as R_from z with the information of the shift.
bool set_places(const IndexedGraph& graph, std::vector<RigidTransform>& poses) {
  TwinEquations equations(graph);
  std::vector<Eigen::Matrix<double, 3, 2>> places(poses.size() - graph.fixed_pose_count,
                                                  Eigen::Matrix<double, 3, 2>::Zero());
  for (const NumberedEdge& edge : graph.edges) {
    const Eigen::Matrix3d measured_from_world =
        (poses[edge.from].rotation * edge.edge->from_from_to.rotation)
            .toRotationMatrix()
            .transpose();
    const Eigen::Matrix3d weight = measured_from_world.transpose() *
                                   edge.edge->information.topLeftCorner<3, 3>() *
                                   measured_from_world;
    equations.add(edge, weight, weight, -weight);
    const Eigen::Vector3d way = poses[edge.from].rotation * edge.edge->from_from_to.translation;
    const auto add = [&](std::uint32_t node, std::uint32_t other,
                         const Eigen::Vector3d& from_other) {
      if (!equations.is_free(node)) return;
      Eigen::Vector3d known = from_other;
      if (!equations.is_free(other)) known += poses[other].translation;
      places[equations.place(node)].colwise() += weight * known;
    };
    add(edge.to, edge.from, way);
    add(edge.from, edge.to, -way);
  }
  if (!equations.factorize()) return false;
  equations.solve(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].allFinite()) return false;
    poses[graph.fixed_pose_count + i].translation = places[i].col(0);
  }
  return true;
}

}  // namespace

std::optional<std::vector<RigidTransform>> chordal_start(const IndexedGraph& graph,
                                                         const Interruption& interruption) {
  std::vector<RigidTransform> poses = graph.world_from_node;
  if (interruption.interrupted() || !set_turns(graph, poses)) return std::nullopt;
  if (interruption.interrupted() || !set_places(graph, poses)) return std::nullopt;
  return poses;
}

}  // namespace roomwise::mapping
