#include "roomwise/objects/proposals/class_size_prior.h"

#include <gtest/gtest.h>

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;

TEST(ClassSizePrior, HoldsThingsAsLargeAsTheyAre) {
  EXPECT_TRUE(size_prior_of("bed").holds({2.0, 0.9, 0.5}));
  EXPECT_TRUE(size_prior_of("bed").holds({1.4, 0.7, 0.9})) << "a cot";
  EXPECT_TRUE(size_prior_of("bed").holds({2.0, 1.0, 2.0})) << "a loft bed";
  EXPECT_TRUE(size_prior_of("bed").holds({2.0, 0.9, 0.2})) << "a mattress";
  EXPECT_TRUE(size_prior_of("table").holds({3.0, 1.2, 0.75}));
  EXPECT_TRUE(size_prior_of("tv").holds({0.62, 0.05, 0.37})) << "of 27 inches";
  EXPECT_TRUE(size_prior_of("bottle").holds({0.08, 0.08, 0.25}));
  EXPECT_TRUE(size_prior_of("chair").holds({0.45, 0.45, 0.85}));
  EXPECT_TRUE(size_prior_of("sink").holds({0.6, 0.45, 0.85}));
  EXPECT_TRUE(size_prior_of("toilet seat").holds({0.4, 0.7, 0.75}));
  EXPECT_TRUE(size_prior_of("tv").holds({1.0, 0.1, 0.6}));
  EXPECT_TRUE(size_prior_of("wardrobe").holds({1.0, 0.6, 2.0}));
  EXPECT_TRUE(size_prior_of("a thing that nobody measured").holds({9, 9, 9}));
}

TEST(ClassSizePrior, HoldsNothingThatIsNeverSoLargeOrSoSmall) {
  EXPECT_FALSE(size_prior_of("bed").holds({1.1, 0.8, 0.5})) << "a coffee table";
  EXPECT_FALSE(size_prior_of("bed").holds({1.8, 1.5, 0.18})) << "a rug";
  EXPECT_FALSE(size_prior_of("bottle").holds({0.1, 0.1, 0.1})) << "a cup";
  EXPECT_FALSE(size_prior_of("bottle").holds({0.25, 0.3, 0.35})) << "a bin";
  EXPECT_FALSE(size_prior_of("chair").holds({0.5, 1.0, 0.25})) << "shoes";
  EXPECT_FALSE(size_prior_of("sink").holds({1.2, 0.6, 0.55})) << "a table";
  EXPECT_FALSE(size_prior_of("table").holds({3.6, 1.4, 0.6})) << "a rug with what lies on it";
  EXPECT_FALSE(size_prior_of("toilet seat").holds({0.38, 0.38, 0.7})) << "a bin";
  EXPECT_FALSE(size_prior_of("tv").holds({1.0, 0.2, 1.2})) << "a window";
  EXPECT_FALSE(size_prior_of("tv").holds({0.3, 0.2, 0.25})) << "a laptop";
  EXPECT_FALSE(size_prior_of("tv").holds({0.8, 0.1, 0.25})) << "a shelf on the wall";
}

TEST(ClassSizePrior, HoldsWhatIsSeenOfThemButNoLessThanAFront) {
  const ClassSizePrior wardrobe = size_prior_of("wardrobe");
  EXPECT_TRUE(wardrobe.fits_when_partial({0.9, 0.3, 1.9})) << "half of its depth";
  EXPECT_FALSE(wardrobe.fits_when_partial({0.9, 0.1, 1.9})) << "a door";
  EXPECT_FALSE(wardrobe.fits_when_partial({0.4, 0.35, 1.9})) << "a narrow bookcase";
  EXPECT_FALSE(size_prior_of("tv").fits_when_partial({0.4, 0.05, 0.3}));
}

TEST(ClassSizePrior, OfWhatIsBuiltInTheFrontAloneMayBeSeen) {
  EXPECT_TRUE(size_prior_of("washing machine").fits_when_partial({0.6, 0.02, 0.8}));
  EXPECT_FALSE(size_prior_of("washing machine").fits_when_partial({0.3, 0.02, 0.8}));
}

TEST(ClassSizePrior, WhatIsSeenMayHoldSomeOfWhatItTouches) {
  const ClassSizePrior bath = size_prior_of("bath");
  EXPECT_TRUE(bath.fits_when_partial({2.5, 0.75, 0.6}));
  EXPECT_FALSE(bath.holds({2.5, 0.75, 0.6}));
  EXPECT_FALSE(bath.fits_when_partial({2.9, 0.75, 0.6}));
}

TEST(ClassSizePrior, FridgesOfTwoMetresAreNarrow) {
  const ClassSizePrior fridge = size_prior_of("fridge");
  EXPECT_TRUE(fridge.holds({0.7, 0.7, 2.03}));
  EXPECT_TRUE(fridge.holds({1.1, 0.8, 1.8}));
  EXPECT_FALSE(fridge.holds({1.1, 0.7, 2.0})) << "a wardrobe";
}

}  // namespace
}  // namespace roomwise::objects
