#include "roomwise/mapping/frontend/appearance_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using features::BinaryDescriptors;
using features::Features;
using features::FloatDescriptors;
using ::testing::IsEmpty;
using ::testing::SizeIs;

template <typename Descriptors>
Features with(Descriptors descriptors) {
  Features features;
  features.keypoints.resize(static_cast<std::size_t>(descriptors.rows()));
  features.descriptors = std::move(descriptors);
  return features;
}
Features real_features(int count, std::uint64_t seed) {
  RandomStream random(seed);
  FloatDescriptors descriptors = FloatDescriptors::NullaryExpr(
      count, 64, [&](Eigen::Index, Eigen::Index) { return static_cast<float>(random.normal()); });
  descriptors.rowwise().normalize();
  return with(descriptors);
}
Features binary_features(int count, std::uint64_t seed) {
  RandomStream random(seed);
  return with(
      BinaryDescriptors(BinaryDescriptors::NullaryExpr(count, 32, [&](Eigen::Index, Eigen::Index) {
        return static_cast<std::uint8_t>(random.index(256));
      })));
}
// The same features seen again: turned by about 0.1 rad, or with five of 256 bits flipped; in
// another order.
Features seen_again(const Features& features, std::uint64_t seed) {
  RandomStream random(seed);
  Features again = features;
  if (auto* real = std::get_if<FloatDescriptors>(&again.descriptors)) {
    *real = real->colwise().reverse().eval();
    *real += FloatDescriptors::NullaryExpr(
        real->rows(), real->cols(),
        [&](Eigen::Index, Eigen::Index) { return static_cast<float>(0.0125 * random.normal()); });
    real->rowwise().normalize();
  } else {
    auto& binary = std::get<BinaryDescriptors>(again.descriptors);
    binary = binary.colwise().reverse().eval();
    for (Eigen::Index row = 0; row < binary.rows(); ++row) {
      for (int flip = 0; flip < 5; ++flip) {
        const auto bit = static_cast<Eigen::Index>(random.index(256));
        binary(row, bit / 8) ^= static_cast<std::uint8_t>(1U << (bit % 8));
      }
    }
  }
  return again;
}

// SURF stands for all real descriptors, ORB for the binary ones.
class AppearanceIndexTest : public ::testing::TestWithParam<features::FeatureKind> {
 protected:
  static Features some_features(int count, std::uint64_t seed) {
    return GetParam() == features::FeatureKind::kOrb ? binary_features(count, seed)
                                                     : real_features(count, seed);
  }
};

TEST_P(AppearanceIndexTest, FindsTheKeyframeThatWasSeenAgain) {
  constexpr KeyframeId kKeyframes = 60;
  AppearanceIndex index(1);
  for (KeyframeId id = 0; id < kKeyframes; ++id) index.add(id, some_features(100, id));
  for (const KeyframeId id : {0, 17, 59}) {
    const auto hits = index.find(seen_again(some_features(100, id), 99), 0, kKeyframes, 3);
    ASSERT_FALSE(hits.empty());
    EXPECT_EQ(hits[0].id, id);
    EXPECT_GT(hits[0].votes, 50) << "of 400: 100 features in four tables";
    for (std::size_t i = 1; i < hits.size(); ++i) EXPECT_LT(hits[i].votes, 0.1 * hits[0].votes);
  }
  for (const auto& chance : index.find(some_features(100, 1000), 0, kKeyframes, 3)) {
    EXPECT_LT(chance.votes, 5) << "never seen before";
  }
}

TEST_P(AppearanceIndexTest, PutsTheMoreAlikeFirst) {
  // Key-frame 5 holds all of the features, 2 half of them, 8 a quarter.
  const Features all = some_features(100, 1);
  const auto top = [&](Eigen::Index count) {
    return std::visit(
        [count](const auto& descriptors) {
          return with(std::decay_t<decltype(descriptors)>(descriptors.topRows(count)));
        },
        all.descriptors);
  };
  AppearanceIndex index(1);
  index.add(2, top(50));
  index.add(5, all);
  index.add(8, top(25));
  index.add(9, some_features(100, 2));
  const auto hits = index.find(all, 0, 10, 3);
  ASSERT_THAT(hits, SizeIs(3));
  EXPECT_EQ(hits[0].id, 5U);
  EXPECT_EQ(hits[1].id, 2U);
  EXPECT_EQ(hits[2].id, 8U);
  EXPECT_THAT(index.find(all, 0, 10, 2), SizeIs(2));
  EXPECT_THAT(index.find(all, 0, 10, 0), IsEmpty());
}

TEST_P(AppearanceIndexTest, OfEqualsTheEarlierComesFirst) {
  const Features features = some_features(50, 1);
  AppearanceIndex index(1);
  for (const KeyframeId id : {7, 3, 5}) index.add(id, features);
  const auto hits = index.find(features, 0, 10, 10);
  ASSERT_THAT(hits, SizeIs(3));
  EXPECT_EQ(hits[0].id, 3U);
  EXPECT_EQ(hits[1].id, 5U);
  EXPECT_EQ(hits[2].id, 7U);
  EXPECT_EQ(hits[0].votes, hits[2].votes);
}

TEST_P(AppearanceIndexTest, NamesOnlyKeyframesBeforeTheOneGiven) {
  const Features features = some_features(50, 1);
  AppearanceIndex index(1);
  for (const KeyframeId id : {3, 5, 7}) index.add(id, features);
  const auto hits = index.find(features, 0, 5, 10);
  ASSERT_THAT(hits, SizeIs(1));
  EXPECT_EQ(hits[0].id, 3U);
  EXPECT_THAT(index.find(features, 0, 3, 10), IsEmpty());
}

TEST_P(AppearanceIndexTest, PassesOverWhatTooManyShare) {
  AppearanceIndexOptions options;
  options.max_in_bucket = 3;
  AppearanceIndex index(1, options);
  const Features common = some_features(50, 1);
  for (const KeyframeId id : {0, 1, 2}) index.add(id, common);
  EXPECT_THAT(index.find(common, 0, 10, 10), SizeIs(3)) << "so many may";
  index.add(3, common);
  EXPECT_THAT(index.find(common, 0, 10, 10), IsEmpty());
  index.add(4, some_features(50, 2));
  EXPECT_THAT(index.find(some_features(50, 2), 0, 10, 10), SizeIs(1)) << "others still count";
}

TEST_P(AppearanceIndexTest, LooksAtTheStrongestFeaturesOnly) {
  AppearanceIndexOptions options;
  options.features = 50;
  AppearanceIndex index(1, options);
  index.add(0, some_features(100, 1));
  const double votes = index.find(some_features(100, 1), 0, 1, 1).at(0).votes;
  EXPECT_DOUBLE_EQ(votes, 50.0 * static_cast<double>(options.tables));
}

TEST_P(AppearanceIndexTest, WithoutFeaturesThereIsNothing) {
  AppearanceIndex index(1);
  EXPECT_THAT(index.find(some_features(50, 1), 0, 10, 3), IsEmpty()) << "nothing was added";
  index.add(0, some_features(0, 1));
  EXPECT_THAT(index.find(some_features(50, 1), 0, 10, 3), IsEmpty())
      << "nothing was in what was added";
  index.add(1, some_features(50, 1));
  EXPECT_THAT(index.find(some_features(0, 1), 0, 10, 3), IsEmpty()) << "nothing is asked for";
  EXPECT_THAT(index.find(some_features(50, 1), 0, 10, 3), SizeIs(1));
}

TEST_P(AppearanceIndexTest, AnswersTheSameForTheSameSeed) {
  AppearanceIndex first(7), second(7);
  for (KeyframeId id = 0; id < 20; ++id) {
    first.add(id, some_features(100, id));
    second.add(id, some_features(100, id));
  }
  const Features query = seen_again(some_features(100, 4), 1);
  const auto a = first.find(query, 0, 20, 20);
  const auto b = second.find(query, 0, 20, 20);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].votes, b[i].votes);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, AppearanceIndexTest,
                         ::testing::Values(features::FeatureKind::kSurf,
                                           features::FeatureKind::kOrb),
                         [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST(AppearanceIndexOptions, SaysWhichFieldIsWrong) {
  EXPECT_OK(AppearanceIndexOptions{}.validate());
  EXPECT_ERROR(AppearanceIndexOptions{.features = 0}.validate(), "features = 0");
  EXPECT_ERROR(AppearanceIndexOptions{.tables = 0}.validate(), "tables = 0");
  EXPECT_ERROR(AppearanceIndexOptions{.max_in_bucket = 0}.validate(), "max_in_bucket = 0");
  EXPECT_ERROR(AppearanceIndexOptions{.bits = 0}.validate(), "bits = 0");
  EXPECT_ERROR(AppearanceIndexOptions{.bits = 33}.validate(), "bits = 33");
  EXPECT_OK((AppearanceIndexOptions{.bits = 32}.validate()));
}

TEST(AppearanceIndex, OfSomeIsAsIfTheOthersHadNeverBeenAdded) {
  constexpr std::uint64_t kKeyframes = 150;
  AppearanceIndex all(1, {.features = 10, .bits = 4}), some(1, {.features = 10, .bits = 4});
  std::vector<KeyframeId> kept;
  for (std::uint64_t id = 0; id < kKeyframes; ++id) {
    all.add(id, real_features(10, id));
    if (id % 3 == 1) continue;
    some.add(kept.size(), real_features(10, id));
    kept.push_back(id);
  }
  all.keep_only(kept);
  PlainWriter of_all, of_some;
  all.write(of_all);
  some.write(of_some);
  EXPECT_EQ(of_all.take(), of_some.take()) << "full buckets, too";

  all.renumber(kept);
  const auto hits = all.find(real_features(10, 3), 0, kKeyframes, kKeyframes);
  EXPECT_TRUE(std::ranges::all_of(hits, [](const auto& hit) { return hit.id % 3 != 1; }));
}

TEST(AppearanceIndex, LeavesOutWhatItIsAskedWithout) {
  AppearanceIndex index(1);
  for (std::uint64_t id = 0; id < 4; ++id) index.add(id, real_features(50, id % 2));
  const std::vector<bool> left_out{false, true, false, false};
  const auto hits = index.find(real_features(50, 1), 0, 4, 4, left_out);
  ASSERT_FALSE(hits.empty());
  EXPECT_EQ(hits.front().id, 3U);
}

TEST(AppearanceIndex, FindsTheSameHoweverManyWereMerged) {
  // More than wait to be merged, and enough that some buckets are shared by many.
  constexpr std::uint64_t kKeyframes = 150;
  AppearanceIndex index(1, {.features = 10, .bits = 6});
  for (std::uint64_t id = 0; id < kKeyframes; ++id) {
    index.add(id, real_features(10, id));
    const auto hits = index.find(real_features(10, id), 0, kKeyframes, 1);
    ASSERT_THAT(hits, SizeIs(1));
    EXPECT_EQ(hits.front().id, id);
  }
  PlainWriter writer;
  index.write(writer);
  const Bytes bytes = writer.take();
  PlainReader reader(bytes);
  AppearanceIndex again(1, {.features = 10, .bits = 6});
  again.read(reader);
  EXPECT_TRUE(reader.is_whole());
  for (const std::uint64_t asked : {0, 63, 64, 149}) {
    const auto one = index.find(real_features(10, asked), 20, 140, 9);
    const auto other = again.find(real_features(10, asked), 20, 140, 9);
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].id, other[i].id);
      EXPECT_EQ(one[i].votes, other[i].votes);
    }
  }
}

}  // namespace
}  // namespace roomwise::mapping
