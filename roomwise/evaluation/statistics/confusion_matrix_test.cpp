#include "roomwise/evaluation/statistics/confusion_matrix.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

TEST(ConfusionMatrix, CountsByTruthAndAnswer) {
  ConfusionMatrix matrix;
  EXPECT_TRUE(matrix.empty());
  for (int i = 0; i < 3; ++i) matrix.add("kitchen", "kitchen");
  matrix.add("kitchen", "bath");
  matrix.add("bath", "bath");
  matrix.add("bath", "hall");  // never a truth

  EXPECT_THAT(matrix.rooms(), ::testing::ElementsAre("bath", "hall", "kitchen"));
  EXPECT_EQ(matrix.count("kitchen", "kitchen"), 3);
  EXPECT_EQ(matrix.count("kitchen", "bath"), 1);
  EXPECT_EQ(matrix.count("hall", "bath"), 0);
  EXPECT_EQ(matrix.precision("bath"), (Proportion{1, 2}));
  EXPECT_EQ(matrix.recall("bath"), (Proportion{1, 2}));
  EXPECT_EQ(matrix.precision("kitchen"), (Proportion{3, 3}));
  EXPECT_EQ(matrix.recall("kitchen"), (Proportion{3, 4}));
  EXPECT_EQ(matrix.recall("hall"), (Proportion{0, 0}));
}

}  // namespace
}  // namespace roomwise::evaluation
