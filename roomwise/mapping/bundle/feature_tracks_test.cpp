#include "roomwise/mapping/bundle/feature_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::mapping {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<std::size_t> kSizes{3, 3, 3, 3};

TEST(JoinTracks, JoinsMatchesThatShareAFeature) {
  EXPECT_THAT(join_tracks(kSizes, {{{2, 1}, {1, 0}, 0.1F}, {{0, 2}, {1, 0}, 0.2F}}),
              ElementsAre(ElementsAre(FeatureId{0, 2}, FeatureId{1, 0}, FeatureId{2, 1})));
  EXPECT_THAT(join_tracks(kSizes, {}), IsEmpty());
}

TEST(JoinTracks, JoinsTwoTracksAndKeepsOthersApart) {
  EXPECT_THAT(
      join_tracks(kSizes, {{{2, 0}, {3, 0}, 0.1F},
                           {{0, 0}, {1, 0}, 0.1F},
                           {{1, 0}, {2, 0}, 0.3F},
                           {{0, 1}, {3, 2}, 0.2F}}),
      ElementsAre(ElementsAre(FeatureId{0, 0}, FeatureId{1, 0}, FeatureId{2, 0}, FeatureId{3, 0}),
                  ElementsAre(FeatureId{0, 1}, FeatureId{3, 2})));
}

TEST(JoinTracks, NeverPutsTwoFeaturesOfAKeyframeTogetherAndPrefersTheMoreAlike) {
  // Feature (1, 0) is matched with two of key-frame 0, by way of key-frame 2 for one of them.
  EXPECT_THAT(
      join_tracks(kSizes, {{{0, 1}, {1, 0}, 0.4F}, {{0, 0}, {2, 0}, 0.2F}, {{1, 0}, {2, 0}, 0.3F}}),
      ElementsAre(ElementsAre(FeatureId{0, 0}, FeatureId{1, 0}, FeatureId{2, 0})));
}

}  // namespace
}  // namespace roomwise::mapping
