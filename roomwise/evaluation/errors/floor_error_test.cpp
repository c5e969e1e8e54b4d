#include "roomwise/evaluation/errors/floor_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::evaluation {
namespace {

// '.' is free; all lines are of one length.
StandingRoom room(const std::vector<std::string>& rows) {
  StandingRoom free(static_cast<int>(rows.front().size()), static_cast<int>(rows.size()));
  for (int y = 0; y < free.height(); ++y) {
    for (int x = 0; x < free.width(); ++x) {
      free.at(x, y) = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] == '.' ? 1 : 0;
    }
  }
  return free;
}

TEST(FloorError, CountsWhatIsFreeInBoth) {
  const auto error = floor_error(room({"....##", "....##"}), room({".....#", "##...#"}), 0.5);
  ASSERT_OK(error);
  EXPECT_NEAR(error->true_m2, 2, 1e-12);
  EXPECT_NEAR(error->found_m2, 2, 1e-12);
  EXPECT_NEAR(error->both_m2, 1.5, 1e-12);
  EXPECT_NEAR(error->precision, 0.75, 1e-12);
  EXPECT_NEAR(error->recall, 0.75, 1e-12);
  EXPECT_EQ(error->precision_within_cell, 1) << "the fifth column lies beside the fourth";
  EXPECT_EQ(error->recall_within_cell, 1);
}

TEST(FloorError, OfTwoCellsAsideIsAnError) {
  const auto error = floor_error(room({".###"}), room({"###."}), 1);
  ASSERT_OK(error);
  EXPECT_EQ(error->precision_within_cell, 0);
  EXPECT_EQ(error->recall_within_cell, 0);
  EXPECT_EQ(floor_error(room({"##"}), room({"##"}), 1)->precision, 0);
  EXPECT_ERROR(floor_error(room({"##"}), room({"#"}), 1), "2x1");
}

}  // namespace
}  // namespace roomwise::evaluation
