#include "roomwise/features/surf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "roomwise/base/testing.h"
#include "roomwise/features/keypoint_selection.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/opencv_extractors.h"
#include "roomwise/features/surf_detector.h"
#include "roomwise/features/test_pictures.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::features {
namespace {

using testing::blob_picture;
using testing::textured_picture;

constexpr double kPi = std::numbers::pi;

// Gaussian derivatives answer a blob of sigma t most strongly at s = t. The box filters are wider
// than the Gaussians they stand for (a lobe of 3 px for s = 1.2), so they do so at s = 0.74 t; what
// counts for matching is that this factor is the same at every size.
TEST(Surf, FindsABlobAtItsCentreAndScale) {
  const SurfExtractor surf({});
  for (const double sigma_px : {2.5, 4.0, 6.0, 10.0}) {
    for (const Eigen::Vector2d& centre :
         {Eigen::Vector2d(100, 90), Eigen::Vector2d(103.3, 95.75), Eigen::Vector2d(98.5, 91.5)}) {
      for (const double amplitude : {120.0, -120.0}) {
        SCOPED_TRACE(::testing::Message()
                     << sigma_px << " at " << centre.transpose() << ", " << amplitude);
        const auto picture = blob_picture(200, 190, centre, sigma_px, 128, amplitude);
        const Features features = surf.extract(picture);
        ASSERT_GT(features.size(), 0U);
        const Keypoint& found = features.keypoints[0];
        EXPECT_LT((found.position_px.cast<double>() - centre).norm(), 0.1)
            << found.position_px.transpose();
        EXPECT_NEAR(found.size_px / 20 / sigma_px, 0.74, 0.05);
        EXPECT_EQ(found.bright, amplitude > 0);
      }
    }
  }
}

TEST(Surf, TheSamplingStepDoesNotMoveABlob) {
  const Eigen::Vector2d centre(103.3, 95.75);
  const auto picture = blob_picture(200, 190, centre, 4, 60, 150);
  for (const int step : {1, 2, 3}) {
    const Features features = SurfExtractor({.initial_step = step}).extract(picture);
    ASSERT_GT(features.size(), 0U);
    EXPECT_LT((features.keypoints[0].position_px.cast<double>() - centre).norm(), 0.2) << step;
  }
}

// The box filters know no direction but the rows and columns: a quarter turn changes nothing.
TEST(Surf, TurnsWithThePicture) {
  const auto picture = textured_picture(300, 240, 1);
  const Features upright = SurfExtractor({}).extract(picture);
  const Features turned = SurfExtractor({}).extract(testing::turned_by_quarter(picture));
  ASSERT_GT(upright.size(), 300U);
  const auto matches = match_features(upright, turned);
  std::size_t right_place = 0, right_turn = 0;
  for (const Match& match : matches) {
    const Keypoint& a = upright.keypoints[match.query];
    const Keypoint& b = turned.keypoints[match.train];
    const Eigen::Vector2f expected(239 - a.position_px.y(), a.position_px.x());
    right_place += (b.position_px - expected).norm() < 0.5F ? 1 : 0;
    const double turn = std::remainder(b.angle_rad - a.angle_rad - kPi / 2, 2 * kPi);
    right_turn += std::abs(turn) < 0.1 ? 1 : 0;
  }
  EXPECT_GT(matches.size(), upright.size() * 7 / 10);
  EXPECT_GT(right_place, matches.size() * 97 / 100);
  EXPECT_GT(right_turn, matches.size() * 95 / 100);
}

TEST(Surf, UprightFeaturesHaveNoAngle) {
  const auto picture = textured_picture(200, 150, 2);
  const Features features = SurfExtractor({.upright = true}).extract(picture);
  ASSERT_GT(features.size(), 50U);
  for (const Keypoint& keypoint : features.keypoints) EXPECT_EQ(keypoint.angle_rad, 0);
}

// Descriptors are sums of differences, normalised: neither an offset nor a factor of the light may
// change them.
TEST(Surf, DescriptorsDoNotDependOnTheLight) {
  image::GrayImage dim = textured_picture(240, 200, 3);
  for (auto& pixel : dim.pixels()) pixel = static_cast<std::uint8_t>(pixel / 3);
  image::GrayImage shifted = dim, scaled = dim;
  for (auto& pixel : shifted.pixels()) pixel = static_cast<std::uint8_t>(pixel + 57);
  for (auto& pixel : scaled.pixels()) pixel = static_cast<std::uint8_t>(pixel * 3);

  const SurfExtractor weak({.hessian_threshold = 1, .most_keypoints = 0});
  const SurfExtractor strong({.hessian_threshold = 9, .most_keypoints = 0});
  const Features expected = weak.extract(dim);
  ASSERT_GT(expected.size(), 50U);
  const auto& rows = std::get<RealDescriptors>(expected.descriptors);

  const Features in_shifted = weak.extract(shifted);
  ASSERT_EQ(in_shifted.size(), expected.size());
  EXPECT_EQ(std::get<RealDescriptors>(in_shifted.descriptors), rows);

  // The determinant grows by the square of the factor.
  const Features in_scaled = strong.extract(scaled);
  ASSERT_EQ(in_scaled.size(), expected.size());
  const RealDescriptors difference = std::get<RealDescriptors>(in_scaled.descriptors) - rows;
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-4);
}

TEST(Surf, LeavesOutSlantedEdges) {
  image::GrayImage picture(300, 240);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const double beyond_px = 0.9 * (y - 120) - 0.4 * (x - 150);
      picture.at(x, y) =
          static_cast<std::uint8_t>(std::lround(60 + 140 / (1 + std::exp(-beyond_px))));
    }
  }
  EXPECT_GT(SurfExtractor({.most_edge_ratio = 0}).extract(picture).size(), 25U);
  EXPECT_LT(SurfExtractor({.most_edge_ratio = 4}).extract(picture).size(), 5U);
}

TEST(Surf, KeepsTheStrongest) {
  const auto picture = textured_picture(300, 240, 4);
  const Features all = SurfExtractor({.most_keypoints = 0}).extract(picture);
  const Features few = SurfExtractor({.most_keypoints = 50}).extract(picture);
  ASSERT_GT(all.size(), 200U);
  ASSERT_EQ(few.size(), 50U);
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few.keypoints[i].position_px, all.keypoints[i].position_px);
  }
}

TEST(Surf, SpreadsKeypointsOverThePicture) {
  // Strong texture in the left half, the same at a fifth of the contrast in the right.
  image::GrayImage picture = textured_picture(400, 200, 5);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 200; x < 400; ++x) {
      picture.at(x, y) = static_cast<std::uint8_t>(100 + (picture.at(x, y) - 100) / 5);
    }
  }
  const auto count_right = [&](int spread_cells) {
    SurfOptions options{.hessian_threshold = 0.1};
    options.most_keypoints = 100;
    options.spread_cells = spread_cells;
    const Features features = SurfExtractor(options).extract(picture);
    EXPECT_EQ(features.size(), 100U);
    return std::count_if(features.keypoints.begin(), features.keypoints.end(),
                         [](const Keypoint& k) { return k.position_px.x() > 205; });
  };
  EXPECT_LT(count_right(0), 10);
  EXPECT_GT(count_right(8), 35);
}

TEST(SelectKeypoints, TakesTheBestOfEachCellFirst) {
  // Two cells across: three key-points in the left one, one weak one in the right.
  std::vector<Keypoint> keypoints(4);
  const float places[] = {10, 20, 30, 150};
  const float responses[] = {5, 9, 7, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    keypoints[i].position_px = {places[i], 10};
    keypoints[i].response = responses[i];
  }
  const auto responses_of = [](const std::vector<Keypoint>& selected) {
    std::vector<float> values;
    for (const Keypoint& keypoint : selected) values.push_back(keypoint.response);
    return values;
  };
  using ::testing::ElementsAre;
  EXPECT_THAT(responses_of(select_keypoints(keypoints, 2, 200, 100, 0)), ElementsAre(9, 7));
  EXPECT_THAT(responses_of(select_keypoints(keypoints, 2, 200, 100, 2)), ElementsAre(9, 1));
  EXPECT_THAT(responses_of(select_keypoints(keypoints, 3, 200, 100, 2)), ElementsAre(9, 7, 1));
  EXPECT_THAT(responses_of(select_keypoints(keypoints, 9, 200, 100, 2)), ElementsAre(9, 7, 5, 1));
}

struct Score {
  std::size_t matches = 0;
  std::size_t correct = 0;
  [[nodiscard]] double share() const {
    return static_cast<double>(correct) / static_cast<double>(matches);
  }
};

// Matches of a picture with its warp, and how many of them are within 2 px of the truth.
Score match_with_warp(FeatureKind kind, const image::GrayImage& picture, double angle_deg,
                      double scale, double blur_sigma_px) {
  const auto warped = testing::warp(picture, angle_deg, scale, blur_sigma_px);
  const auto extractor = make_extractor(kind, 1000);
  const Features a = extractor->extract(picture);
  const Features b = extractor->extract(warped.picture);
  Score score;
  for (const Match& match : match_features(a, b)) {
    const Eigen::Vector2d expected =
        warped.warped_from_original * a.keypoints[match.query].position_px.cast<double>();
    const Eigen::Vector2d found = b.keypoints[match.train].position_px.cast<double>();
    ++score.matches;
    score.correct += (found - expected).norm() < 2 ? 1 : 0;
  }
  return score;
}

struct Warp {
  const char* name;
  double angle_deg, scale, blur_sigma_px;
  // What is asked of SURF: correct among its matches, and its correct matches for each of SIFT's.
  double least_share, least_part_of_sift;
};

void expect_repeatable(const image::GrayImage& picture, std::span<const Warp> warps) {
  for (const Warp& warp : warps) {
    const Score surf = match_with_warp(FeatureKind::kSurf, picture, warp.angle_deg, warp.scale,
                                       warp.blur_sigma_px);
    const Score sift = match_with_warp(FeatureKind::kSift, picture, warp.angle_deg, warp.scale,
                                       warp.blur_sigma_px);
    SCOPED_TRACE(::testing::Message()
                 << warp.name << ": SURF " << surf.correct << " of " << surf.matches << ", SIFT "
                 << sift.correct << " of " << sift.matches);
    EXPECT_GE(surf.share(), warp.least_share);
    EXPECT_GE(static_cast<double>(surf.correct),
              warp.least_part_of_sift * static_cast<double>(sift.correct));
  }
}

TEST(Surf, IsFoundAgainInAWarpedTexture) {
  const Warp warps[] = {{"turn30", 30, 1, 0, 0.80, 0.55},
                        {"scale1.3", 0, 1.3, 0, 0.82, 0.75},
                        {"blur2", 0, 1, 2, 0.9, 1},
                        {"turn30_scale1.3_blur1", 30, 1.3, 1, 0.65, 0.55}};
  expect_repeatable(textured_picture(480, 360, 6), warps);
}

TEST(Surf, IsFoundAgainInAWarpedRealPicture) {
  const auto path = roomwise::testing::find_data("office_walk/rgb/00003.jpg");
  ROOMWISE_REQUIRE_FILE(path);
  const auto picture = image::read_color(*path);
  ASSERT_OK(picture);
  // A hard one: smooth walls, long edges, little texture.
  const Warp warps[] = {{"turn30", 30, 1, 0, 0.55, 0.2},
                        {"scale1.3", 0, 1.3, 0, 0.55, 0.35},
                        {"blur2", 0, 1, 2, 0.8, 0.9},
                        {"turn30_scale1.3_blur1", 30, 1.3, 1, 0.5, 0.3}};
  expect_repeatable(image::to_gray(*picture), warps);
}

TEST(SurfOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(SurfOptions{}.validate());
  EXPECT_ERROR(SurfOptions{.hessian_threshold = -1}.validate(), "hessian_threshold");
  EXPECT_ERROR(SurfOptions{.hessian_threshold = std::nan("")}.validate(), "hessian_threshold");
  EXPECT_ERROR(SurfOptions{.octaves = 0}.validate(), "octaves");
  EXPECT_ERROR(SurfOptions{.intervals = 2}.validate(), "intervals");
  EXPECT_ERROR(SurfOptions{.initial_step = 0}.validate(), "initial_step");
  EXPECT_ERROR(SurfOptions{.most_edge_ratio = 0.5}.validate(), "most_edge_ratio");
  EXPECT_ERROR(SurfOptions{.most_keypoints = -1}.validate(), "most_keypoints");
  EXPECT_ERROR(SurfOptions{.spread_cells = -1}.validate(), "spread_cells");
  EXPECT_THROW(SurfExtractor({.octaves = 9}), std::invalid_argument);
}

TEST(SurfOptions, OtherOctavesAndIntervalsWork) {
  const auto picture = blob_picture(300, 280, {140, 130}, 4, 60, 150);
  for (const int octaves : {1, 3, 5}) {
    for (const int intervals : {3, 4, 5, 8}) {
      const SurfExtractor surf({.octaves = octaves, .intervals = intervals});
      const Features features = surf.extract(picture);
      // Three intervals of the first octave alone end at 21 px, below this blob's 30.
      if (octaves == 1 && intervals <= 4) continue;
      ASSERT_GT(features.size(), 0U) << octaves << " " << intervals;
      EXPECT_LT((features.keypoints[0].position_px - Eigen::Vector2f(140, 130)).norm(), 0.1F);
    }
  }
}

}  // namespace
}  // namespace roomwise::features
