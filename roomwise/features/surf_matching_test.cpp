#include <gtest/gtest.h>

#include <span>

#include "roomwise/base/testing/testing.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/testing/test_pictures.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

// SURF beside SIFT on warped pictures.
namespace roomwise::features {
namespace {

using testing::textured_picture;

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
  double min_share, min_part_of_sift;
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
    EXPECT_GE(surf.share(), warp.min_share);
    EXPECT_GE(static_cast<double>(surf.correct),
              warp.min_part_of_sift * static_cast<double>(sift.correct));
  }
}

constexpr Warp kWarps[] = {{"turn30", 30, 1, 0, 0.9, 0.8},
                           {"scale1.3", 0, 1.3, 0, 0.85, 0.8},
                           {"blur2", 0, 1, 2, 0.85, 1.3},
                           {"turn30_scale1.3_blur1", 30, 1.3, 1, 0.85, 0.85}};

TEST(Surf, IsFoundAgainInAWarpedTexture) {
  expect_repeatable(textured_picture(480, 360, 6), kWarps);
}

TEST(Surf, IsFoundAgainInAWarpedRealPicture) {
  const auto path = roomwise::testing::find_data("office_walk/rgb/00003.jpg");
  ROOMWISE_REQUIRE_FILE(path);
  const auto picture = image::read_color(*path);
  ASSERT_OK(picture);
  // A hard one: smooth walls, long edges, little texture.
  expect_repeatable(image::to_gray(*picture), kWarps);
}

}  // namespace
}  // namespace roomwise::features
