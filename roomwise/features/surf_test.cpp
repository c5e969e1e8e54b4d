#include "roomwise/features/surf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "roomwise/base/testing/testing.h"
#include "roomwise/features/keypoint_selection.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/testing/test_pictures.h"

namespace roomwise::features {
namespace {

using testing::blob_picture;
using testing::textured_picture;

// Gaussian derivatives answer a blob of sigma t most strongly at s = t. The box filters are wider
// than the Gaussians they stand for (a lobe of 3 px for s = 1.2), so they do so at s = 0.74 t, and
// the smoothing of the octave where a blob is found adds up to 17 % to that.
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
        EXPECT_NEAR(found.size_px / 20 / sigma_px, 0.8, 0.07);
        EXPECT_EQ(found.bright, amplitude > 0);
      }
    }
  }
}

// The double size and the pyramid's octaves have pixels of other sizes and places than the picture.
TEST(Surf, FindsTheSameBlobFromEverySize) {
  const Eigen::Vector2d centre(103.3, 95.75);
  for (const double sigma_px : {1.3, 3.0, 6.5, 13.0}) {
    const auto picture = blob_picture(240, 230, centre, sigma_px, 60, 150);
    for (const bool doubled : {false, true}) {
      if (!doubled && sigma_px < 2) continue;  // too small for the single size
      const Features features = SurfExtractor({.doubled = doubled}).extract(picture);
      ASSERT_GT(features.size(), 0U);
      EXPECT_LT((features.keypoints[0].position_px.cast<double>() - centre).norm(),
                0.03 + 0.04 * sigma_px)
          << sigma_px << (doubled ? " doubled" : " single");
    }
  }
}

void expect_equal(const Features& a, const Features& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.keypoints[i].position_px, b.keypoints[i].position_px);
    EXPECT_EQ(a.keypoints[i].size_px, b.keypoints[i].size_px);
    EXPECT_EQ(a.keypoints[i].angle_rad, b.keypoints[i].angle_rad);
    EXPECT_EQ(a.keypoints[i].response, b.keypoints[i].response);
    EXPECT_EQ(a.keypoints[i].bright, b.keypoints[i].bright);
  }
  EXPECT_EQ(std::get<FloatDescriptors>(a.descriptors), std::get<FloatDescriptors>(b.descriptors));
}

TEST(Surf, GivesTheSameBitsOnEveryProcessor) {
  // Where there is neither AVX2 nor NEON the portable one is all there is.
  ASSERT_EQ(process_simd(), best_simd());
  const SurfOptions options{.hessian_threshold = 0, .max_keypoints = 0};
  const SurfExtractor portable(options, Simd::kPortable), best(options, process_simd());
  // Widths of every remainder by eight, and more than one strip.
  for (int i = 0; i < 9; ++i) {
    const auto picture = textured_picture(330 + i, 200 - i, static_cast<std::uint64_t>(i));
    const Features features = best.extract(picture);
    ASSERT_GT(features.size(), 200U);
    expect_equal(portable.extract(picture), features);
  }
}

TEST(Surf, GivesTheSameBitsInEveryThreadAndAfterOtherPictures) {
  const SurfExtractor surf({});
  std::vector<image::GrayImage> pictures;
  std::vector<Features> expected;
  for (int i = 0; i < 4; ++i) {
    pictures.push_back(textured_picture(160 + 50 * i, 200 - 20 * i, 9));
    expected.push_back(SurfExtractor({}).extract(pictures.back()));
  }
  std::vector<Features> found(12);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < 4; ++i) found[4 * t + i] = surf.extract(pictures[(i + t) % 4]);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 0; t < 3; ++t) {
    for (std::size_t i = 0; i < 4; ++i) expect_equal(found[4 * t + i], expected[(i + t) % 4]);
  }
}

TEST(Surf, PicturesTooSmallForAFilterHaveNoFeatures) {
  for (const auto& [width, height] : {std::pair(0, 0), {1, 1}, {3, 200}, {14, 14}}) {
    EXPECT_EQ(SurfExtractor({}).extract(image::GrayImage(width, height, 9)).size(), 0U);
  }
}

// The box filters know no direction but the rows and columns: a quarter turn changes nothing.
TEST(Surf, TurnsWithThePicture) {
  const auto picture = textured_picture(300, 240, 1);
  const Features upright = SurfExtractor({}).extract(picture);
  const Features turned = SurfExtractor({}).extract(testing::turned_by_quarter(picture));
  ASSERT_GT(upright.size(), 250U);
  const auto matches = match_features(upright, turned);
  std::size_t right_place = 0, right_turn = 0;
  for (const Match& match : matches) {
    const Keypoint& a = upright.keypoints[match.query];
    const Keypoint& b = turned.keypoints[match.train];
    const Eigen::Vector2f expected(239 - a.position_px.y(), a.position_px.x());
    right_place += (b.position_px - expected).norm() < 0.5F ? 1 : 0;
    const double turn =
        std::remainder(b.angle_rad - a.angle_rad - std::numbers::pi / 2, 2 * std::numbers::pi);
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

  const SurfExtractor surf({.hessian_threshold = 1, .max_keypoints = 0});
  const Features expected = surf.extract(dim);
  ASSERT_GT(expected.size(), 50U);

  const Features in_shifted = surf.extract(shifted);
  ASSERT_EQ(in_shifted.size(), expected.size());
  EXPECT_EQ(std::get<FloatDescriptors>(in_shifted.descriptors),
            std::get<FloatDescriptors>(expected.descriptors));

  // Brighter, so that more are above the threshold; smoothing rounds to a sixteenth of a grey
  // level.
  const Features in_scaled = surf.extract(scaled);
  const auto matches = match_features(expected, in_scaled);
  EXPECT_GT(matches.size(), expected.size() * 95 / 100);
  const auto alike =
      std::ranges::count_if(matches, [](const Match& match) { return match.distance < 0.05F; });
  EXPECT_GT(alike, std::ssize(matches) * 95 / 100);
}

// A bar is no point: along it nothing says where one is.
TEST(Surf, LeavesOutBars) {
  image::GrayImage picture(300, 240);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const double across_px = 0.8 * (y - 120) - 0.6 * (x - 150);
      const double along_px = 0.6 * (y - 120) + 0.8 * (x - 150);
      const double squared =
          across_px * across_px / (4.0 * 4.0) + along_px * along_px / (24.0 * 24.0);
      picture.at(x, y) = static_cast<std::uint8_t>(std::lround(60 + 140 * std::exp(-squared / 2)));
    }
  }
  EXPECT_GT(SurfExtractor({.max_edge_ratio = 0}).extract(picture).size(), 0U);
  EXPECT_EQ(SurfExtractor({.max_edge_ratio = 4}).extract(picture).size(), 0U);
}

TEST(Surf, KeepsTheStrongest) {
  const auto picture = textured_picture(300, 240, 4);
  const Features all = SurfExtractor({.max_keypoints = 0}).extract(picture);
  const Features few = SurfExtractor({.max_keypoints = 50}).extract(picture);
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
    options.max_keypoints = 100;
    options.spread_cells = spread_cells;
    const Features features = SurfExtractor(options).extract(picture);
    EXPECT_EQ(features.size(), 100U);
    return std::count_if(features.keypoints.begin(), features.keypoints.end(),
                         [](const Keypoint& k) { return k.position_px.x() > 205; });
  };
  EXPECT_LT(count_right(0), 10);
  EXPECT_GT(count_right(8), 35);
}

// As evenly as the picture allows: of two cells, the one with fewer has no more to give.
TEST(Surf, FillsAllCellsAlike) {
  constexpr int kCells = 8;
  const auto picture = textured_picture(400, 400, 5);
  const auto count_by_cell = [&](std::size_t most) {
    const SurfExtractor surf(
        {.hessian_threshold = 5, .max_keypoints = static_cast<int>(most), .spread_cells = kCells});
    std::vector<int> counts(kCells * kCells);
    for (const Keypoint& keypoint : surf.extract(picture).keypoints) {
      const Eigen::Vector2i cell = ((keypoint.position_px.array() + 0.5F) / 50).cast<int>();
      ++counts[static_cast<std::size_t>(kCells * cell.y() + cell.x())];
    }
    return counts;
  };
  const std::vector<int> all = count_by_cell(0), some = count_by_cell(200);
  ASSERT_GT(std::accumulate(all.begin(), all.end(), 0), 400);
  EXPECT_EQ(std::accumulate(some.begin(), some.end(), 0), 200);
  const int most = *std::ranges::max_element(some);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_GE(some[i], std::min(all[i], most - 1));
}

TEST(KeypointSelection, TakesTheBestOfEachCellFirst) {
  // Two cells across: three key-points in the left one, one weak one in the right.
  std::vector<Keypoint> keypoints(4);
  const float places[] = {10, 20, 30, 150};
  const float responses[] = {5, 9, 7, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    keypoints[i].position_px = {places[i], 10};
    keypoints[i].response = responses[i];
  }
  KeypointSelection selection;
  const auto select = [&](std::size_t most, int cells) {
    std::vector<Keypoint> selected = keypoints;
    selection.select(selected, most, 200, 100, cells);
    std::vector<float> values;
    for (const Keypoint& keypoint : selected) values.push_back(keypoint.response);
    return values;
  };
  using ::testing::ElementsAre;
  EXPECT_THAT(select(2, 0), ElementsAre(9, 7));
  EXPECT_THAT(select(2, 2), ElementsAre(9, 1));
  EXPECT_THAT(select(3, 2), ElementsAre(9, 7, 1));
  EXPECT_THAT(select(9, 2), ElementsAre(9, 7, 5, 1));
  EXPECT_THAT(select(0, 2), ElementsAre(9, 7, 5, 1));
}

TEST(SurfOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(SurfOptions{}.validate());
  EXPECT_ERROR(SurfOptions{.hessian_threshold = -1}.validate(), "hessian_threshold");
  EXPECT_ERROR(SurfOptions{.hessian_threshold = std::nan("")}.validate(), "hessian_threshold");
  EXPECT_ERROR(SurfOptions{.octaves = 0}.validate(), "octaves");
  EXPECT_ERROR(SurfOptions{.max_edge_ratio = 0.5}.validate(), "max_edge_ratio");
  EXPECT_ERROR(SurfOptions{.max_keypoints = -1}.validate(), "max_keypoints");
  EXPECT_ERROR(SurfOptions{.spread_cells = -1}.validate(), "spread_cells");
  EXPECT_THROW(SurfExtractor({.octaves = 9}), std::invalid_argument);
}

TEST(SurfOptions, OtherOctavesWork) {
  const auto picture = blob_picture(300, 280, {140, 130}, 4, 60, 150);
  for (const int octaves : {3, 4, 5, 6}) {
    for (const bool doubled : {false, true}) {
      const SurfExtractor surf({.octaves = octaves, .doubled = doubled});
      const Features features = surf.extract(picture);
      ASSERT_GT(features.size(), 0U) << octaves;
      EXPECT_LT((features.keypoints[0].position_px - Eigen::Vector2f(140, 130)).norm(), 0.1F);
    }
  }
}

}  // namespace
}  // namespace roomwise::features
