#include "roomwise/objects/own_things/placed_features.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "roomwise/features/matcher.h"

namespace roomwise::objects {
namespace {

using Affine = Eigen::Matrix<float, 2, 3>;

// Of the view's diagonal, as it lies in the picture. A view of something that is not flat bends
// when it is seen from aside.
constexpr float kLooseShare = 0.15F, kCloseShare = 0.06F;
constexpr float kMaxSizeRatio = 2;
constexpr std::size_t kMinAgreeing = 3;  // as an affine transform needs

struct Pair {
  const features::Keypoint* view;
  const features::Keypoint* picture;
};

Affine transform_of(const Pair& pair) {
  const float scale = pair.picture->size_px / pair.view->size_px;
  const float turn_rad = pair.picture->angle_rad - pair.view->angle_rad;
  const float cosine = scale * std::cos(turn_rad), sine = scale * std::sin(turn_rad);
  Affine transform;
  transform.leftCols<2>() << cosine, -sine, sine, cosine;
  transform.col(2) = pair.picture->position_px - transform.leftCols<2>() * pair.view->position_px;
  return transform;
}

float scale_of(const Affine& transform) {
  return std::sqrt(std::abs(transform.leftCols<2>().determinant()));
}

std::vector<Pair> agreeing(const std::vector<Pair>& pairs, const Affine& transform,
                           float tolerance_px) {
  const float scale = scale_of(transform);
  std::vector<Pair> fit;
  std::set<const features::Keypoint*> used;  // several of the view may match one of the picture
  for (const Pair& pair : pairs) {
    const Eigen::Vector2f expected =
        transform.leftCols<2>() * pair.view->position_px + transform.col(2);
    const float size_ratio = pair.picture->size_px / (scale * pair.view->size_px);
    const bool is_of_size = size_ratio < kMaxSizeRatio && size_ratio > 1 / kMaxSizeRatio;
    const bool is_near = (expected - pair.picture->position_px).norm() < tolerance_px * scale;
    if (is_of_size && is_near && used.insert(pair.picture).second) fit.push_back(pair);
  }
  return fit;
}

// By least squares; nothing where the pairs lie on a line, or the view would be mirrored or flat.
std::optional<Affine> affine_through(const std::vector<Pair>& pairs) {
  const auto rows = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXf from(rows, 3), to(rows, 2);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    from.row(i) << pair.view->position_px.transpose(), 1;
    to.row(i) = pair.picture->position_px.transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXf> solver(from);
  if (solver.rank() < 3) return std::nullopt;
  const Affine transform = solver.solve(to).transpose();
  const float area = transform.leftCols<2>().determinant();
  const float longest = transform.leftCols<2>().norm();
  // Seen from 75 degrees aside one side is a quarter as long; s and s / 4 have this ratio.
  constexpr float kFlattest = 0.25F / (1 + 0.25F * 0.25F);
  if (area <= kFlattest * longest * longest) return std::nullopt;
  return transform;
}

network::PixelBox outline_of_view(const Affine& transform, int width_px, int height_px) {
  const auto width = static_cast<float>(width_px), height = static_cast<float>(height_px);
  Eigen::Matrix<float, 3, 4> corners;
  corners << 0, width, 0, width, 0, 0, height, height, 1, 1, 1, 1;
  const Eigen::Matrix<float, 2, 4> seen = transform * corners;
  return {seen.row(0).minCoeff(), seen.row(1).minCoeff(), seen.row(0).maxCoeff(),
          seen.row(1).maxCoeff()};
}

}  // namespace

std::optional<PlacedView> verify_view(const features::Features& view, int width_px, int height_px,
                                      const features::Features& picture) {
  std::vector<Pair> pairs;
  for (const features::Match& match : features::match_features(view, picture)) {
    pairs.push_back({&view.keypoints[match.query], &picture.keypoints[match.train]});
  }
  if (pairs.size() < kMinAgreeing) return std::nullopt;
  const float diagonal_px = std::hypot(static_cast<float>(width_px), static_cast<float>(height_px));
  std::vector<Pair> best;
  for (const Pair& pair : pairs) {
    auto fit = agreeing(pairs, transform_of(pair), kLooseShare * diagonal_px);
    if (fit.size() > best.size()) best = std::move(fit);
  }
  if (best.size() < kMinAgreeing) return std::nullopt;
  const auto through_all = affine_through(best);
  if (!through_all) return std::nullopt;
  best = agreeing(best, *through_all, kCloseShare * diagonal_px);
  if (best.size() < kMinAgreeing) return std::nullopt;
  PlacedView placed{best.size(), outline_of_view(*through_all, width_px, height_px), {}};
  for (const Pair& pair : best) placed.places_px.push_back(pair.picture->position_px);
  return placed;
}

}  // namespace roomwise::objects
