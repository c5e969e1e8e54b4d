#include "roomwise/objects/kind_shape.h"

#include <gtest/gtest.h>

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;

TEST(KindShape, HoldsThingsAsLargeAsTheyAre) {
  EXPECT_TRUE(shape_of("bed").holds({2.0, 0.9, 0.5}));
  EXPECT_TRUE(shape_of("bed").holds({1.4, 0.7, 0.9})) << "a cot";
  EXPECT_TRUE(shape_of("bed").holds({2.0, 1.0, 2.0})) << "a loft bed";
  EXPECT_TRUE(shape_of("bed").holds({2.0, 0.9, 0.2})) << "a mattress";
  EXPECT_TRUE(shape_of("table").holds({3.0, 1.2, 0.75}));
  EXPECT_TRUE(shape_of("tv").holds({0.62, 0.05, 0.37})) << "of 27 inches";
  EXPECT_TRUE(shape_of("bottle").holds({0.08, 0.08, 0.25}));
  EXPECT_TRUE(shape_of("chair").holds({0.45, 0.45, 0.85}));
  EXPECT_TRUE(shape_of("sink").holds({0.6, 0.45, 0.85}));
  EXPECT_TRUE(shape_of("toilet seat").holds({0.4, 0.7, 0.75}));
  EXPECT_TRUE(shape_of("tv").holds({1.0, 0.1, 0.6}));
  EXPECT_TRUE(shape_of("wardrobe").holds({1.0, 0.6, 2.0}));
  EXPECT_TRUE(shape_of("a thing that nobody measured").holds({9, 9, 9}));
}

TEST(KindShape, HoldsNothingThatIsNeverSoLargeOrSoSmall) {
  EXPECT_FALSE(shape_of("bed").holds({1.1, 0.8, 0.5})) << "a coffee table";
  EXPECT_FALSE(shape_of("bed").holds({1.8, 1.5, 0.18})) << "a rug";
  EXPECT_FALSE(shape_of("bottle").holds({0.1, 0.1, 0.1})) << "a cup";
  EXPECT_FALSE(shape_of("bottle").holds({0.25, 0.3, 0.35})) << "a bin";
  EXPECT_FALSE(shape_of("chair").holds({0.5, 1.0, 0.25})) << "shoes";
  EXPECT_FALSE(shape_of("sink").holds({1.2, 0.6, 0.55})) << "a table";
  EXPECT_FALSE(shape_of("table").holds({3.6, 1.4, 0.6})) << "a rug with what lies on it";
  EXPECT_FALSE(shape_of("toilet seat").holds({0.38, 0.38, 0.7})) << "a bin";
  EXPECT_FALSE(shape_of("tv").holds({1.0, 0.2, 1.2})) << "a window";
  EXPECT_FALSE(shape_of("tv").holds({0.3, 0.2, 0.25})) << "a laptop";
  EXPECT_FALSE(shape_of("tv").holds({0.8, 0.1, 0.25})) << "a shelf on the wall";
}

TEST(KindShape, HoldsWhatIsSeenOfThemButNoLessThanAFront) {
  const KindShape wardrobe = shape_of("wardrobe");
  EXPECT_TRUE(wardrobe.holds_what_is_seen({0.9, 0.3, 1.9})) << "half of its depth";
  EXPECT_FALSE(wardrobe.holds_what_is_seen({0.9, 0.1, 1.9})) << "a door";
  EXPECT_FALSE(wardrobe.holds_what_is_seen({0.4, 0.35, 1.9})) << "a narrow bookcase";
  EXPECT_FALSE(shape_of("tv").holds_what_is_seen({0.4, 0.05, 0.3}));
}

TEST(KindShape, OfWhatIsBuiltInTheFrontAloneMayBeSeen) {
  EXPECT_TRUE(shape_of("washing machine").holds_what_is_seen({0.6, 0.02, 0.8}));
  EXPECT_FALSE(shape_of("washing machine").holds_what_is_seen({0.3, 0.02, 0.8}));
}

TEST(KindShape, WhatIsSeenMayHoldSomeOfWhatItTouches) {
  const KindShape bath = shape_of("bath");
  EXPECT_TRUE(bath.holds_what_is_seen({2.5, 0.75, 0.6}));
  EXPECT_FALSE(bath.holds({2.5, 0.75, 0.6}));
  EXPECT_FALSE(bath.holds_what_is_seen({2.9, 0.75, 0.6}));
}

TEST(KindShape, FridgesOfTwoMetresAreNarrow) {
  const KindShape fridge = shape_of("fridge");
  EXPECT_TRUE(fridge.holds({0.7, 0.7, 2.03}));
  EXPECT_TRUE(fridge.holds({1.1, 0.8, 1.8}));
  EXPECT_FALSE(fridge.holds({1.1, 0.7, 2.0})) << "a wardrobe";
  EXPECT_TRUE(fridge.is_exceeded_by({1.1, 0.7, 2.0}));
}

TEST(KindShape, FewFridgesAreLow) {
  EXPECT_TRUE(shape_of("fridge").holds({0.6, 0.6, 0.85}));
  EXPECT_FALSE(shape_of("fridge").is_usual({0.6, 0.6, 0.85}));
  EXPECT_TRUE(shape_of("fridge").is_usual({0.6, 0.6, 1.7}));
  EXPECT_TRUE(shape_of("chair").is_usual({0.45, 0.45, 0.45}));
}

}  // namespace
}  // namespace roomwise::objects
