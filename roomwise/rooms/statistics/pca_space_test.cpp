#include "roomwise/rooms/statistics/pca_space.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "roomwise/base/random.h"

namespace roomwise::rooms {
namespace {

Eigen::MatrixXf random_rows(Eigen::Index rows, Eigen::Index features, std::uint64_t seed) {
  RandomStream random(seed);
  Eigen::MatrixXf matrix(rows, features);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < features; ++j) {
      // The first feature varies most.
      matrix(i, j) = static_cast<float>(random.normal() * (j == 0 ? 5 : 1));
    }
  }
  return matrix;
}

TEST(RootFeatures, AreRootsOfLengthOne) {
  const Eigen::VectorXf roots = root_features(std::vector<float>{9, 0, 16, -4});
  EXPECT_NEAR(roots.norm(), 1, 1e-6);
  EXPECT_NEAR(roots[0] / roots[2], 0.75, 1e-6) << "roots of 9 and 16";
  EXPECT_EQ(roots[3], 0) << "below zero";
  EXPECT_TRUE(roots.isApprox(root_features(std::vector<float>{90, 0, 160, 0})));
  EXPECT_EQ(root_features(std::vector<float>{0, 0}).norm(), 0);
}

TEST(PcaSpace, FindsTheDirectionsThatVaryMost) {
  const PcaSpace space = PcaSpace::fit(random_rows(40, 6, 1));
  ASSERT_EQ(space.directions().cols(), 6);
  EXPECT_GT(std::abs(space.directions()(0, 0)), 0.95) << "the first feature";
  const Eigen::MatrixXf products = space.directions().transpose() * space.directions();
  EXPECT_TRUE(products.isApprox(Eigen::MatrixXf::Identity(6, 6), 1e-3F));
  for (Eigen::Index i = 1; i < 6; ++i) EXPECT_LE(space.deviations()[i], space.deviations()[i - 1]);
}

TEST(PcaSpace, PlacesHaveTheDeviationsThatItSays) {
  const Eigen::MatrixXf rows = random_rows(50, 5, 2);
  const PcaSpace space = PcaSpace::fit(rows);
  const Eigen::MatrixXf projections = space.projections(rows);
  for (Eigen::Index i = 0; i < projections.cols(); ++i) {
    const float deviation = std::sqrt(projections.col(i).squaredNorm() / 50);
    EXPECT_NEAR(deviation, space.deviations()[i], 1e-3 * space.deviations()[0]);
    EXPECT_NEAR(projections.col(i).mean(), 0, 1e-4);
  }
}

TEST(PcaSpace, WhiteningLetsWeakDirectionsCount) {
  const PcaSpace space = PcaSpace::fit(random_rows(40, 6, 1));
  // A step along the strongest and one along the weakest direction: beforehand the first is most
  // of the place.
  Eigen::MatrixXf place = Eigen::MatrixXf::Zero(1, 6);
  place(0, 0) = space.deviations()[0];
  place(0, 5) = space.deviations()[5];
  const Eigen::MatrixXf white = space.whitened(place);
  EXPECT_NEAR(white.norm(), 1, 1e-5);
  EXPECT_GT(white(0, 5) / white(0, 0), 1.5F * place(0, 5) / place(0, 0));
}

TEST(PcaSpace, ComparesWholePicturesCoarsely) {
  const Eigen::MatrixXf rows = random_rows(30, 4, 3);
  const PcaSpace space = PcaSpace::fit(rows);
  // With all directions kept nothing is lost: it is the inner product.
  const Eigen::VectorXf picture = rows.row(7);
  EXPECT_TRUE(space.plain_cosine(picture, space.projections(rows)).isApprox(rows * picture, 1e-3F));
}

TEST(PcaSpace, PicturesThatAreAllAlikeHaveNoDirections) {
  const PcaSpace space = PcaSpace::fit(Eigen::MatrixXf::Constant(5, 3, 0.5F));
  EXPECT_EQ(space.directions().cols(), 0);
  const Eigen::MatrixXf projections = space.projections(Eigen::MatrixXf::Ones(2, 3));
  EXPECT_EQ(space.whitened(projections).cols(), 0);
  EXPECT_NEAR(space.plain_cosine(Eigen::Vector3f(1, 1, 1), projections)[0], 1.5, 1e-5);
}

TEST(PcaSpace, KeepsNoMoreThanItSays) {
  const PcaSpace space = PcaSpace::fit(random_rows(700, 300, 4));
  EXPECT_EQ(space.directions().cols(), PcaSpace::kMaxDirections);
  EXPECT_THROW(PcaSpace::fit(Eigen::MatrixXf(0, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
