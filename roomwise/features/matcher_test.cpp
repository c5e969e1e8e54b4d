#include "roomwise/features/matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::features {
namespace {

using ::testing::IsEmpty;

Features random_real(std::size_t count, Eigen::Index values, std::uint64_t seed,
                     bool both_polarities) {
  RandomStream random(seed);
  FloatDescriptors rows(count, values);
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    rows.data()[i] = static_cast<float>(random.normal());
  }
  rows.rowwise().normalize();
  Features features{std::vector<Keypoint>(count), rows};
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.bright = both_polarities && random.index(2) == 1;
  }
  return features;
}

// Each of the first rows is near one of base's, in turned order; further ones are at random.
Features disturbed(const Features& base, std::size_t count, float noise, std::uint64_t seed) {
  const auto& from = std::get<FloatDescriptors>(base.descriptors);
  Features features = random_real(count, from.cols(), seed, true);
  auto& rows = std::get<FloatDescriptors>(features.descriptors);
  const std::size_t shared = std::min(count, base.size()) / 2;
  for (std::size_t i = 0; i < shared; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    rows.row(row) = (from.row(from.rows() - 1 - row) + noise * rows.row(row)).normalized();
    features.keypoints[i].bright = base.keypoints[base.size() - 1 - i].bright;
  }
  return features;
}

Features random_binary(std::size_t count, Eigen::Index bytes, std::uint64_t seed) {
  RandomStream random(seed);
  BinaryDescriptors rows(count, bytes);
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    rows.data()[i] = static_cast<std::uint8_t>(random.index(256));
  }
  return {std::vector<Keypoint>(count), rows};
}

double distance(const Features& a, std::size_t i, const Features& b, std::size_t j) {
  const auto p = static_cast<Eigen::Index>(i);
  const auto q = static_cast<Eigen::Index>(j);
  if (const auto* rows = std::get_if<FloatDescriptors>(&a.descriptors)) {
    const auto& others = std::get<FloatDescriptors>(b.descriptors);
    return (rows->row(p).cast<double>() - others.row(q).cast<double>()).norm();
  }
  const auto& rows = std::get<BinaryDescriptors>(a.descriptors);
  const auto& others = std::get<BinaryDescriptors>(b.descriptors);
  int bits = 0;
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    for (int different = rows(p, k) ^ others(q, k); different != 0; different >>= 1) {
      bits += different & 1;
    }
  }
  return bits;
}

struct Neighbours {
  std::size_t nearest = 0;
  double first = std::numeric_limits<double>::infinity();
  double second = std::numeric_limits<double>::infinity();
};

Neighbours neighbours_of(const Features& a, std::size_t i, const Features& b) {
  Neighbours found;
  for (std::size_t j = 0; j < b.size(); ++j) {
    if (a.keypoints[i].bright != b.keypoints[j].bright) continue;
    const double d = distance(a, i, b, j);
    if (d < found.first) {
      found.second = found.first;
      found.first = d;
      found.nearest = j;
    } else if (d < found.second) {
      found.second = d;
    }
  }
  return found;
}

// The contract in plain loops.
std::vector<Match> matched_plainly(const Features& query, const Features& train,
                                   const MatchOptions& options) {
  std::vector<Match> matches;
  for (std::size_t i = 0; i < query.size(); ++i) {
    const Neighbours found = neighbours_of(query, i, train);
    if (std::isinf(found.first)) continue;
    if (options.max_distance_ratio < 1) {
      if (std::isinf(found.second)) continue;
      if (!(found.first < options.max_distance_ratio * found.second)) continue;
    }
    if (options.mutual && neighbours_of(train, found.nearest, query).nearest != i) continue;
    matches.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(found.nearest),
                       static_cast<float>(found.first)});
  }
  return matches;
}

void expect_same(const std::vector<Match>& found, const std::vector<Match>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].query, expected[i].query);
    EXPECT_EQ(found[i].train, expected[i].train);
    EXPECT_NEAR(found[i].distance, expected[i].distance, 1e-3);
  }
}

TEST(MatchFeatures, EqualsPlainLoopsOnFloatDescriptors) {
  // Sizes that fill no block, one block and more.
  for (const std::size_t count : {2U, 7U, 64U, 65U, 200U}) {
    const Features query = random_real(count, 64, count, true);
    const Features train = disturbed(query, count + 30, 0.4F, count + 1);
    for (const bool mutual : {false, true}) {
      for (const double ratio : {0.7, 0.9, 1.0}) {
        SCOPED_TRACE(::testing::Message() << count << " " << mutual << " " << ratio);
        const MatchOptions options{.max_distance_ratio = ratio, .mutual = mutual};
        const auto expected = matched_plainly(query, train, options);
        EXPECT_TRUE(count < 64 || expected.size() > count / 4) << expected.size();
        expect_same(match_features(query, train, options), expected);
      }
    }
  }
}

TEST(MatchFeatures, AnOddNumberOfValuesIsComparedToTheLast) {
  Features query = random_real(2, 3, 1, false);
  std::get<FloatDescriptors>(query.descriptors) << 0.6F, 0, 0.8F, 0.6F, 0, -0.8F;
  Features train = query;
  std::get<FloatDescriptors>(train.descriptors).colwise().reverseInPlace();
  expect_same(match_features(query, train), {{0, 1, 0}, {1, 0, 0}});
}

void expect_same_with_all_instructions(const Features& query, const Features& train) {
  const auto portable = match_features(query, train, {}, Simd::kPortable);
  const auto best = match_features(query, train, {}, process_simd());
  ASSERT_GT(portable.size(), 20U);
  ASSERT_EQ(best.size(), portable.size());
  for (std::size_t i = 0; i < best.size(); ++i) {
    EXPECT_EQ(best[i].query, portable[i].query);
    EXPECT_EQ(best[i].train, portable[i].train);
    EXPECT_EQ(best[i].distance, portable[i].distance);
  }
}

TEST(MatchFeatures, AllInstructionsGiveTheSameBits) {
  const Features real = random_real(203, 64, 11, true);
  expect_same_with_all_instructions(real, disturbed(real, 331, 0.5F, 12));
  const Features binary = random_binary(90, 61, 13);
  expect_same_with_all_instructions(binary, binary);
}

TEST(MatchFeatures, EqualsPlainLoopsOnBinaryDescriptors) {
  for (const Eigen::Index bytes : {32, 5, 61}) {  // also lengths that are no whole words
    const Features query = random_binary(90, bytes, 1);
    Features train = random_binary(120, bytes, 2);
    auto& rows = std::get<BinaryDescriptors>(train.descriptors);
    for (Eigen::Index i = 0; i < 60; ++i) {
      rows.row(i) = std::get<BinaryDescriptors>(query.descriptors).row(89 - i);
      rows(i, 0) = static_cast<std::uint8_t>(rows(i, 0) ^ 5);
    }
    for (const bool mutual : {false, true}) {
      const MatchOptions options{.max_distance_ratio = 0.8, .mutual = mutual};
      const auto expected = matched_plainly(query, train, options);
      EXPECT_GE(expected.size(), 50U);
      expect_same(match_features(query, train, options), expected);
    }
  }
}

TEST(MatchFeatures, MutualMatchesAreSymmetric) {
  const Features a = random_real(150, 64, 3, true);
  const Features b = disturbed(a, 170, 0.3F, 4);
  const MatchOptions options{.max_distance_ratio = 1, .mutual = true};
  auto turned = match_features(b, a, options);
  for (Match& match : turned) std::swap(match.query, match.train);
  std::sort(turned.begin(), turned.end(),
            [](const Match& p, const Match& q) { return p.query < q.query; });
  const auto matches = match_features(a, b, options);
  EXPECT_FALSE(matches.empty());
  expect_same(turned, matches);
}

TEST(MatchFeatures, NothingMatchesNothing) {
  const Features some = random_real(10, 64, 5, false);
  const Features none{{}, FloatDescriptors(0, 64)};
  EXPECT_THAT(match_features(none, some), IsEmpty());
  EXPECT_THAT(match_features(some, none), IsEmpty());
  EXPECT_THAT(match_features(none, none), IsEmpty());
  const Features no_bits{{}, BinaryDescriptors(0, 32)};
  EXPECT_THAT(match_features(no_bits, random_binary(3, 32, 1)), IsEmpty());
}

TEST(MatchFeatures, ASingleCandidateCannotPassTheRatioTest) {
  const Features one = random_real(1, 64, 6, false);
  EXPECT_THAT(match_features(one, one), IsEmpty());
  const auto untested = match_features(one, one, {.max_distance_ratio = 1, .mutual = true});
  ASSERT_EQ(untested.size(), 1U);
  EXPECT_NEAR(untested[0].distance, 0, 1e-3);
}

TEST(MatchFeatures, TwoEquallyNearCandidatesAreNoMatch) {
  Features twins = random_real(2, 64, 7, false);
  auto& rows = std::get<FloatDescriptors>(twins.descriptors);
  rows.row(1) = rows.row(0);
  EXPECT_THAT(match_features(twins, twins, {.max_distance_ratio = 0.99, .mutual = false}),
              IsEmpty());
}

TEST(MatchFeatures, LightAndDarkBlobsNeverMatch) {
  Features dark = random_real(20, 64, 8, false);
  Features light = dark;
  for (Keypoint& keypoint : light.keypoints) keypoint.bright = true;
  EXPECT_EQ(match_features(dark, dark).size(), 20U);
  EXPECT_THAT(match_features(dark, light), IsEmpty());
}

TEST(MatchFeatures, RefusesDescriptorsThatCannotBeCompared) {
  const Features real = random_real(3, 64, 9, false);
  EXPECT_THROW((void)match_features(real, random_binary(3, 32, 9)), std::invalid_argument);
  EXPECT_THROW((void)match_features(real, random_real(3, 128, 9, false)), std::invalid_argument);
  EXPECT_THROW((void)match_features(real, real, {.max_distance_ratio = 0}), std::invalid_argument);
}

TEST(MatchOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(MatchOptions{}.validate());
  for (const double ratio : {0.0, -0.5, 1.5, std::nan("")}) {
    EXPECT_ERROR(MatchOptions{.max_distance_ratio = ratio}.validate(), "max_distance_ratio");
  }
}

}  // namespace
}  // namespace roomwise::features
