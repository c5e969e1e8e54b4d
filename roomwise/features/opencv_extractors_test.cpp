#include "roomwise/features/opencv_extractors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/surf.h"
#include "roomwise/features/testing/test_pictures.h"

namespace roomwise::features {
namespace {

using testing::textured_picture;

// As the pipeline does at its start: OpenCV starts no threads of its own. (The thread sanitizer
// cannot see into those and would report races.)
class OneOpenCvThread : public ::testing::Environment {
  void SetUp() override { cv::setNumThreads(1); }
};
[[maybe_unused]] const auto* const kOneOpenCvThread =
    ::testing::AddGlobalTestEnvironment(new OneOpenCvThread);

const FeatureKind kAllKinds[] = {FeatureKind::kSurf, FeatureKind::kSift, FeatureKind::kOrb};

bool same(const Features& a, const Features& b) {
  if (a.descriptors != b.descriptors || a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Keypoint& p = a.keypoints[i];
    const Keypoint& q = b.keypoints[i];
    if (p.position_px != q.position_px || p.size_px != q.size_px || p.angle_rad != q.angle_rad ||
        p.response != q.response || p.bright != q.bright) {
      return false;
    }
  }
  return true;
}

class EveryExtractor : public ::testing::TestWithParam<FeatureKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryExtractor, ::testing::ValuesIn(kAllKinds),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST_P(EveryExtractor, GivesAtMostSoManyStrongestFirstWithARowEach) {
  const auto picture = textured_picture(320, 240, 1);
  const Features features = make_extractor(GetParam(), 150)->extract(picture);
  ASSERT_GT(features.size(), 100U);
  ASSERT_LE(features.size(), 150U);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    const Keypoint& before = features.keypoints[i > 0 ? i - 1 : 0];
    EXPECT_LE(keypoint.response, before.response);
    EXPECT_GT(keypoint.size_px, 0);
    EXPECT_LE(std::abs(keypoint.angle_rad), std::numbers::pi + 1e-6);
    EXPECT_TRUE(keypoint.position_px.x() >= -0.5F && keypoint.position_px.x() <= 319.5F);
    EXPECT_TRUE(keypoint.position_px.y() >= -0.5F && keypoint.position_px.y() <= 239.5F);
  }
  if (const auto* real = std::get_if<FloatDescriptors>(&features.descriptors)) {
    ASSERT_EQ(real->rows(), static_cast<Eigen::Index>(features.size()));
    EXPECT_NEAR(real->rowwise().norm().minCoeff(), 1, 1e-4);
    EXPECT_NEAR(real->rowwise().norm().maxCoeff(), 1, 1e-4);
  } else {
    ASSERT_EQ(std::get<BinaryDescriptors>(features.descriptors).rows(),
              static_cast<Eigen::Index>(features.size()));
  }
}

TEST_P(EveryExtractor, FindsNothingInPicturesWithNothing) {
  const auto extractor = make_extractor(GetParam(), 100);
  for (const auto& picture :
       {image::GrayImage(), image::GrayImage(1, 1, 200), image::GrayImage(8, 8, 10),
        image::GrayImage(3, 400, 90), image::GrayImage(320, 240, 255)}) {
    SCOPED_TRACE(::testing::Message() << picture.width() << "x" << picture.height());
    const Features features = extractor->extract(picture);
    EXPECT_EQ(features.size(), 0U);
    EXPECT_EQ(std::visit([](const auto& rows) { return rows.rows(); }, features.descriptors), 0);
    EXPECT_TRUE(match_features(features, features).empty());
  }
}

TEST_P(EveryExtractor, DoesNotCrashOnSmallPicturesOfNoise) {
  const auto extractor = make_extractor(GetParam(), 100);
  RandomStream random(3);
  for (const int size : {1, 2, 7, 8, 9, 15, 27, 28, 40, 62, 63, 64, 80}) {
    image::GrayImage picture(size, size + 1);
    for (auto& pixel : picture.pixels()) pixel = static_cast<std::uint8_t>(random.index(256));
    EXPECT_LE(extractor->extract(picture).size(), 100U);
  }
}

TEST_P(EveryExtractor, GivesTheSameBitsFromSeveralThreads) {
  const auto picture = textured_picture(320, 240, 2);
  const auto extractor = make_extractor(GetParam(), 300);
  const Features expected = extractor->extract(picture);
  std::vector<Features> found(4);
  {
    std::vector<std::jthread> threads;
    for (Features& features : found) {
      threads.emplace_back([&] { features = extractor->extract(picture); });
    }
  }
  for (const Features& features : found) EXPECT_TRUE(same(features, expected));
}

// Turning a picture by half a circle moves no pixel between pixels, so the same features must be
// found in it turned about its centre. A bias of the places shows twice over.
TEST_P(EveryExtractor, HasNoBiasOfPlace) {
  const auto picture = textured_picture(500, 380, 4);  // ORB's levels are not whole parts of it
  const auto extractor = make_extractor(GetParam(), 1000);
  const Features upright = extractor->extract(picture);
  const Features turned = extractor->extract(testing::turned_by_half(picture));
  const auto matches = match_features(upright, turned);
  ASSERT_GT(matches.size(), upright.size() / 2);
  Eigen::Vector2d small_bias = Eigen::Vector2d::Zero(), large_bias = Eigen::Vector2d::Zero();
  int small_count = 0, large_count = 0, correct = 0;
  std::vector<float> sizes;
  for (const Keypoint& keypoint : upright.keypoints) sizes.push_back(keypoint.size_px);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<int>(sizes.size() / 2), sizes.end());
  const float median_size = sizes[sizes.size() / 2];
  for (const Match& match : matches) {
    const Keypoint& a = upright.keypoints[match.query];
    const Keypoint& b = turned.keypoints[match.train];
    const Eigen::Vector2d twice =
        (a.position_px + b.position_px - Eigen::Vector2f(499, 379)).cast<double>();
    if (twice.norm() > 4) continue;
    ++correct;
    EXPECT_NEAR(std::abs(std::remainder(a.angle_rad - b.angle_rad, 2 * std::numbers::pi)),
                std::numbers::pi, 0.9);
    (a.size_px > median_size ? large_bias : small_bias) += twice / 2;
    (a.size_px > median_size ? large_count : small_count) += 1;
  }
  EXPECT_GT(correct, 0.9 * static_cast<double>(matches.size()));
  EXPECT_LT((small_bias / small_count).norm(), 0.05) << (small_bias / small_count).transpose();
  EXPECT_LT((large_bias / large_count).norm(), 0.1) << (large_bias / large_count).transpose();
}

TEST_P(EveryExtractor, IsNamed) {
  const auto kind = parse_feature_kind(to_string(GetParam()));
  ASSERT_OK(kind);
  EXPECT_EQ(*kind, GetParam());
}

TEST(FeatureKind, RefusesOtherNames) {
  EXPECT_ERROR(parse_feature_kind("brisk"), "surf, sift or orb");
  EXPECT_ERROR(parse_feature_kind("SURF"), "surf, sift or orb");
  EXPECT_ERROR(parse_feature_kind(""), "surf, sift or orb");
}

TEST(SiftExtractor, FindsABlobAtItsCentre) {
  for (const double sigma_px : {2.0, 3.0, 6.0, 11.0}) {
    for (const Eigen::Vector2d& centre : {Eigen::Vector2d(70, 60), Eigen::Vector2d(75.25, 66.5)}) {
      SCOPED_TRACE(::testing::Message() << sigma_px << " at " << centre.transpose());
      const auto picture = testing::blob_picture(150, 130, centre, sigma_px, 60, 150);
      const Features features = SiftExtractor(0).extract(picture);
      ASSERT_GT(features.size(), 0U);
      EXPECT_LT((features.keypoints[0].position_px.cast<double>() - centre).norm(), 0.1)
          << features.keypoints[0].position_px.transpose();
    }
  }
}

TEST(OpenCvExtractors, RefuseImpossibleCounts) {
  EXPECT_THROW(SiftExtractor(-1), std::invalid_argument);
  EXPECT_THROW(OrbExtractor(0), std::invalid_argument);
  EXPECT_NO_THROW(SiftExtractor(0));
}

}  // namespace
}  // namespace roomwise::features
