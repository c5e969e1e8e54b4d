#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/base/file.h"
#include "roomwise/pipeline/testing/mapped_room.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::trials {
namespace {

class FloorEvaluationTest : public pipeline::testing::MappedRoom {
 protected:
  // Of the room, up to `width` columns: a wall all round, and 0.25 m from it a person's middle.
  Expected<FloorEvaluation> floor_of_truth(std::size_t width) {
    std::string rows;
    for (int row = 0; row < 80; ++row) {
      std::string cells(60, '#');
      if (row >= 5 && row < 75) cells.replace(5, 50, std::string(50, '.'));
      rows += (row > 0 ? ",\"" : "\"") + cells.substr(0, width) + "\"";
    }
    EXPECT_OK(write_file(
        folder_ / "floorplan.json",
        std::string_view(R"({"ceiling_height": 2.6, "wall_thickness": 0.1, "rooms": [], "walls": [],
                    "doors": [], "windows": [], "free_space": {"origin": [0, 0], "cell": 0.05,
                    "person_radius": 0.25, "rows": [)" +
                         rows + "]}}")));
    pipeline::testing::write_mapped_pictures(*home_, folder_.path());
    return evaluate_floor(*home_, folder_.path(), run_);
  }
};

TEST_F(FloorEvaluationTest, FreeFloorBeyondTheTruthIsWrong) {
  const auto floor = floor_of_truth(30);  // a room of half the width
  ASSERT_OK(floor);
  EXPECT_NEAR(floor->error.true_m2, 1.25 * 3.5, 1e-9);
  EXPECT_GT(floor->error.found_m2, 2 * 3.5);
  EXPECT_NEAR(floor->error.precision, 0.5, 0.02);
  EXPECT_GT(floor->error.recall_within_cell, 0.97);
}

TEST_F(FloorEvaluationTest, KnowsWhereAPersonMayStand) {
  const auto floor = floor_of_truth(60);
  ASSERT_OK(floor);
  EXPECT_NEAR(floor->error.true_m2, 2.5 * 3.5, 1e-9);
  EXPECT_GT(floor->error.precision_within_cell, 0.99);
  EXPECT_GT(floor->error.recall_within_cell, 0.97);
  EXPECT_NEAR(floor->floor_above_truth_m, 0, 0.005);
  EXPECT_LT(floor->tilt_rad, 0.005);
}

}  // namespace
}  // namespace roomwise::trials
