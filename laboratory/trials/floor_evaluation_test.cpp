#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/base/file.h"
#include "roomwise/pipeline/testing/mapped_room.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::trials {
namespace {

class FloorEvaluationTest : public pipeline::testing::MappedRoom {};

TEST_F(FloorEvaluationTest, KnowsWhereAPersonMayStand) {
  // Truth: a wall all round, and 0.25 m from it a person's middle.
  std::string rows;
  for (int row = 0; row < 80; ++row) {
    std::string cells(60, '#');
    if (row >= 5 && row < 75) cells.replace(5, 50, std::string(50, '.'));
    rows += (row > 0 ? ",\"" : "\"") + cells + "\"";
  }
  ASSERT_OK(write_file(
      folder_ / "floorplan.json",
      std::string_view(R"({"ceiling_height": 2.6, "wall_thickness": 0.1, "rooms": [], "walls": [],
                    "doors": [], "windows": [], "free_space": {"origin": [0, 0], "cell": 0.05,
                    "person_radius": 0.25, "rows": [)" +
                       rows + "]}}")));
  pipeline::testing::write_mapped_pictures(*home_, folder_.path());
  const auto floor = evaluate_floor(*home_, folder_.path(), run_);
  ASSERT_OK(floor);
  EXPECT_NEAR(floor->error.true_m2, 2.5 * 3.5, 1e-9);
  EXPECT_GT(floor->error.precision_within_cell, 0.99);
  EXPECT_GT(floor->error.recall_within_cell, 0.97);
  EXPECT_NEAR(floor->floor_above_truth_m, 0, 0.005);
  EXPECT_LT(floor->tilt_rad, 0.005);
}

}  // namespace
}  // namespace roomwise::trials
