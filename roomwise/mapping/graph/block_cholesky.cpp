#include "roomwise/mapping/graph/block_cholesky.h"

#include <algorithm>

#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/mapping/graph/front_kernels.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using MatrixMap = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;
using ConstMatrixMap = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;
constexpr auto kSize = static_cast<Eigen::Index>(kBlock);

// Where a front's numbers are: its panel, and the square that is left for its parent.
class FrontNumbers {
 public:
  FrontNumbers(const Front& front, double* panel, double* left)
      : panel_{panel, front.columns, stride_of(front)},
        left_(left),
        left_stride_(padded(kBlock * blocks_left(front))) {}

  static std::size_t blocks_left(const Front& front) { return front.rows.size() - front.columns; }
  static std::size_t stride_of(const Front& front) {
    return kBlock * front.columns + padded(kBlock * blocks_left(front));
  }

  [[nodiscard]] const Panel& panel() const { return panel_; }
  // The block at positions among the front's rows, row not before column.
  [[nodiscard]] MatrixMap block(std::size_t row, std::size_t column) const {
    const bool in_panel = column < panel_.columns;
    const std::size_t skipped = in_panel ? 0 : panel_.columns;
    const std::size_t stride = in_panel ? panel_.stride : left_stride_;
    return {(in_panel ? panel_.numbers : left_) + kBlock * (column - skipped) * stride +
                kBlock * (row - skipped),
            kSize, kSize, Eigen::OuterStride<>(static_cast<Eigen::Index>(stride))};
  }

 private:
  Panel panel_;
  double* left_;
  std::size_t left_stride_;
};

}  // namespace

BlockCholesky::BlockCholesky(std::size_t count, std::vector<BlockPair> pairs)
    : pairs_(std::move(pairs)),
      symbolic_(analyze_pattern(count, pairs_)),
      block_at_(count),
      entries_(symbolic_.fronts.size()),
      children_(symbolic_.fronts.size()),
      panels_(symbolic_.fronts.size()) {
  for (std::size_t block = 0; block < count; ++block) block_at_[symbolic_.place[block]] = block;
  std::vector<std::uint32_t> front_of(count);
  for (std::uint32_t i = 0; i < symbolic_.fronts.size(); ++i) {
    const Front& front = symbolic_.fronts[i];
    for (std::size_t k = 0; k < front.columns; ++k) front_of[front.rows[k]] = i;
    if (front.parent != Front::kNone) children_[front.parent].push_back(i);
    panels_[i].resize(kBlock * front.columns * FrontNumbers::stride_of(front));
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const std::uint32_t a = symbolic_.place[pairs_[i].first];
    const std::uint32_t b = symbolic_.place[pairs_[i].second];
    const auto [column, row] = std::minmax({a, b});
    entries_[front_of[column]].push_back({i, row, column, a < b});
  }
}

bool BlockCholesky::factorize(std::span<const Matrix6d> diagonal,
                              std::span<const Matrix6d> off_diagonal) {
  std::vector<std::vector<double>> left(
      symbolic_.fronts.size());                           // by front, until its parent took it
  std::vector<std::uint32_t> position(block_at_.size());  // of a row among those of the front
  for (std::size_t i = 0; i < symbolic_.fronts.size(); ++i) {
    const Front& front = symbolic_.fronts[i];
    const std::size_t blocks_left = FrontNumbers::blocks_left(front);
    for (std::uint32_t k = 0; k < front.rows.size(); ++k) position[front.rows[k]] = k;
    std::ranges::fill(panels_[i], 0.0);
    if (!spare_.empty()) {
      left[i] = std::move(spare_.back());
      spare_.pop_back();
    }
    left[i].assign(kBlock * blocks_left * padded(kBlock * blocks_left), 0.0);
    const FrontNumbers own(front, panels_[i].data(), left[i].data());

    for (std::size_t k = 0; k < front.columns; ++k)
      own.block(k, k) = diagonal[block_at_[front.rows[k]]];
    for (const Entry& entry : entries_[i]) {
      MatrixMap block = own.block(position[entry.row], position[entry.column]);
      const Matrix6d& value = off_diagonal[entry.pair];
      if (entry.transposed) {
        block += value.transpose();
      } else {
        block += value;
      }
    }
    for (const std::uint32_t c : children_[i]) {
      const Front& child = symbolic_.fronts[c];
      const FrontNumbers from(child, panels_[c].data(), left[c].data());
      for (std::size_t column = child.columns; column < child.rows.size(); ++column) {
        for (std::size_t row = column; row < child.rows.size(); ++row) {
          own.block(position[child.rows[row]], position[child.rows[column]]) +=
              from.block(row, column);
        }
      }
      spare_.push_back(std::move(left[c]));
    }
    if (!eliminate(own.panel())) return false;
    subtract_products(own.panel(), blocks_left, left[i].data());
    if (front.parent == Front::kNone) spare_.push_back(std::move(left[i]));
  }
  return true;
}

void BlockCholesky::solve(Eigen::VectorXd& x) const {
  Eigen::VectorXd ordered(x.size());
  for (std::size_t k = 0; k < block_at_.size(); ++k) {
    ordered.segment<kSize>(kSize * static_cast<Eigen::Index>(k)) =
        x.segment<kSize>(kSize * static_cast<Eigen::Index>(block_at_[k]));
  }
  Eigen::VectorXd below;  // the entries of a front's rows below those that it eliminates
  const auto parts = [&](std::size_t i) {
    const Front& front = symbolic_.fronts[i];
    const auto stride = static_cast<Eigen::Index>(FrontNumbers::stride_of(front));
    const auto columns = kSize * static_cast<Eigen::Index>(front.columns);
    const auto rows = kSize * static_cast<Eigen::Index>(FrontNumbers::blocks_left(front));
    below.resize(rows);
    return std::tuple(
        ConstMatrixMap(panels_[i].data(), columns, columns, Eigen::OuterStride<>(stride)),
        ConstMatrixMap(panels_[i].data() + columns, rows, columns, Eigen::OuterStride<>(stride)),
        ordered.segment(kSize * static_cast<Eigen::Index>(front.rows.front()), columns));
  };
  const auto each_row_below = [&](const Front& front, auto&& visit) {
    for (std::size_t k = front.columns; k < front.rows.size(); ++k) {
      visit(below.segment<kSize>(kSize * static_cast<Eigen::Index>(k - front.columns)),
            ordered.segment<kSize>(kSize * static_cast<Eigen::Index>(front.rows[k])));
    }
  };
  for (std::size_t i = 0; i < symbolic_.fronts.size(); ++i) {
    auto [square, rest, own] = parts(i);
    square.triangularView<Eigen::Lower>().solveInPlace(own);
    below.noalias() = rest * own;
    each_row_below(symbolic_.fronts[i], [](auto&& part, auto&& target) { target -= part; });
  }
  for (std::size_t i = symbolic_.fronts.size(); i-- > 0;) {
    auto [square, rest, own] = parts(i);
    each_row_below(symbolic_.fronts[i], [](auto&& part, auto&& source) { part = source; });
    own.noalias() -= rest.transpose() * below;
    square.transpose().triangularView<Eigen::Upper>().solveInPlace(own);
  }
  for (std::size_t k = 0; k < block_at_.size(); ++k) {
    x.segment<kSize>(kSize * static_cast<Eigen::Index>(block_at_[k])) =
        ordered.segment<kSize>(kSize * static_cast<Eigen::Index>(k));
  }
}

Eigen::VectorXd add_damping(std::span<Matrix6d> diagonal, double damping) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> weights(6, static_cast<Eigen::Index>(diagonal.size()));
  Eigen::Index column = 0;
  for (const Matrix6d& block : diagonal) weights.col(column++) = block.diagonal();
  weights = damping * geometry::damping_weights(weights);
  column = 0;
  for (Matrix6d& block : diagonal) block.diagonal() += weights.col(column++);
  return weights.reshaped();
}

}  // namespace roomwise::mapping
