#include "roomwise/fusion/floor_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/floor_map_file.h"
#include "roomwise/fusion/occupancy.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::box;
using testing::half_space;
using ::testing::HasSubstr;
using testing::looking_at;
using testing::RigidTransform;
using testing::Scene;

// A room of 4 m by 3 m, z up, with a table, a shoe, a carpet and a lamp that hangs high.
class FloorGridTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene scene{
        half_space(Vector3d::UnitZ(), 0),      half_space(Vector3d::UnitX(), 0),
        half_space(-Vector3d::UnitX(), -4),    half_space(Vector3d::UnitY(), 0),
        half_space(-Vector3d::UnitY(), -3),    box({1.5, 1.2, 0.70}, {2.5, 1.8, 0.74}),
        box({0.6, 2.2, 0}, {0.9, 2.35, 0.12}), box({3.0, 0.3, 0}, {3.7, 0.9, 0.02}),
        box({2.9, 2.0, 2.0}, {3.2, 2.3, 2.2})};
    std::vector<RigidTransform> cameras;
    for (int i = 0; i < 12; ++i) {
      const double angle = std::numbers::pi * i / 6;
      const Vector3d eye(2 + 1.6 * std::cos(angle), 1.5 + 1.1 * std::sin(angle), 1.5);
      cameras.push_back(looking_at(eye, {2, 1.5, 0.3}));
      cameras.push_back(
          looking_at(eye, {2 + 2.2 * std::cos(angle + 1), 1.5 + 1.7 * std::sin(angle + 1), 0.2}));
      cameras.push_back(
          looking_at({2, 0.6, 1.5}, {2 + std::cos(angle), 0.6 + std::sin(angle), 1.8}));
    }
    ThreadPool pool(2);
    TsdfVolume field = testing::fuse(scene, cameras, pool);
    const PiecewiseMesh mesh = extract_mesh(field, MeshOptions{}, pool).value();
    const auto visit_free = [&](const auto& visit) {
      return visit_free_cells(field, {}, 0.05, pool, visit);
    };
    grid_ = std::make_unique<FloorGrid>(make_floor_grid(mesh, {}, visit_free).value());
  }
  static void TearDownTestSuite() { grid_.reset(); }
  static FloorCell at(double x, double y) { return grid_->at(Vector2d(x, y)); }

  inline static std::unique_ptr<FloorGrid> grid_;
};

TEST_F(FloorGridTest, ThingsInTheWayAreOccupiedAndOthersAreNot) {
  EXPECT_EQ(at(1.0, 0.5), FloorCell::kFree);
  EXPECT_EQ(at(2.0, 1.5), FloorCell::kOccupied) << "under the table";
  EXPECT_EQ(at(0.75, 2.28), FloorCell::kOccupied) << "a shoe";
  EXPECT_EQ(at(3.3, 0.6), FloorCell::kFree) << "a carpet";
  EXPECT_EQ(at(3.05, 2.15), FloorCell::kFree) << "under a lamp that hangs at 2 m";
  EXPECT_EQ(at(-0.5, 1.5), FloorCell::kUnknown) << "behind the wall";
  EXPECT_EQ(at(-9, 40), FloorCell::kUnknown);
  EXPECT_EQ(at(std::nan(""), 0), FloorCell::kUnknown);
}

TEST_F(FloorGridTest, MostOfTheRoomIsWhatItIs) {
  std::size_t right = 0, wrong = 0;
  for (double x = 0.125; x < 3.9; x += 0.05) {
    for (double y = 0.125; y < 2.9; y += 0.05) {
      const bool table = x > 1.5 && x < 2.5 && y > 1.2 && y < 1.8;
      const bool shoe = x > 0.6 && x < 0.9 && y > 2.2 && y < 2.35;
      ++((at(x, y) == FloorCell::kFree) != (table || shoe) ? right : wrong);
    }
  }
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(right + wrong));
}

TEST_F(FloorGridTest, KnowsHowFarTheNearestThingIs) {
  const auto clearance = [](double x, double y) {
    const Vector2d cell = (Vector2d(x, y) - grid_->origin_m()) / grid_->cell_m();
    return grid_->clearance_m(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  };
  EXPECT_NEAR(clearance(1.0, 1.0), 0.54, 0.08) << "to the table's corner";
  EXPECT_EQ(clearance(2.0, 1.5), 0);
  EXPECT_TRUE(grid_->fits(Vector2d(0.7, 1.0), 0.3));
  EXPECT_FALSE(grid_->fits(Vector2d(0.15, 1.0), 0.3)) << "too near to the wall";
  EXPECT_FALSE(grid_->fits(Vector2d(2.0, 1.5), 0.0));
  EXPECT_FALSE(grid_->fits(Vector2d(-3.0, 1.5), 0.3));
}

TEST_F(FloorGridTest, IsWrittenAsRosReadsIt) {
  const roomwise::testing::ScratchFolder folder;
  ASSERT_OK(write_floor_map(folder / "my \"flat.yaml", *grid_));
  const std::string yaml = read_text_file(folder / "my \"flat.yaml").value();
  EXPECT_THAT(yaml, HasSubstr("image: \"my \\\"flat.pgm\"\n"));
  EXPECT_THAT(yaml, HasSubstr("resolution: 0.050000\n"));
  EXPECT_THAT(yaml, HasSubstr(fmt::format("origin: [{:.6f}, {:.6f}, 0.0]\n", grid_->origin_m().x(),
                                          grid_->origin_m().y())));
  EXPECT_THAT(yaml, HasSubstr("negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.15\n"));

  const std::string picture = read_text_file(folder / "my \"flat.pgm").value();
  const std::string header = fmt::format("P5\n{} {}\n255\n", grid_->columns(), grid_->rows());
  ASSERT_THAT(picture, ::testing::StartsWith(header));
  const auto cells = static_cast<std::size_t>(grid_->columns() * grid_->rows());
  ASSERT_EQ(picture.size(), header.size() + cells);
  for (int row = 0; row < grid_->rows(); ++row) {
    for (int column = 0; column < grid_->columns(); ++column) {
      // The picture's first row is the one with the largest y.
      const auto place =
          static_cast<std::size_t>((grid_->rows() - 1 - row) * grid_->columns() + column);
      const double black =
          (255 - static_cast<unsigned char>(picture[header.size() + place])) / 255.0;
      const FloorCell read = black > 0.65   ? FloorCell::kOccupied
                             : black < 0.15 ? FloorCell::kFree
                                            : FloorCell::kUnknown;
      ASSERT_EQ(read, grid_->at(column, row));
    }
  }
  EXPECT_ERROR(write_floor_map(folder / "missing" / "a.yaml", *grid_), "a.pgm");
}

TEST(FloorGrid, OfNothingInTheWayIsClearEverywhere) {
  const FloorGrid grid({0, 0}, 0.05, image::Image<FloorCell>(3, 2, FloorCell::kFree));
  EXPECT_TRUE(std::isinf(grid.clearance_m(1, 1)));
  EXPECT_TRUE(grid.fits(0, 0, 5));
  EXPECT_NEAR(grid.area_m2(FloorCell::kFree), 0.015, 1e-12);
}

// Space over a stairwell was seen empty, as over floor; what lies below tells them apart.
TEST(FloorGrid, WhereOneWouldFallIsOccupied) {
  std::vector<Eigen::Vector3i> cells;
  for (int z = -9; z < 40; ++z) cells.emplace_back(0, 0, z);  // a drop
  for (int z = 1; z < 40; ++z) cells.emplace_back(1, 0, z);   // floor that was not seen
  const auto visit_free = [&](const auto& visit) {
    visit(cells);
    return Expected<void>();
  };
  const auto grid = make_floor_grid({}, {}, visit_free).value();
  EXPECT_EQ(grid.at(0, 0), FloorCell::kOccupied);
  EXPECT_EQ(grid.at(1, 0), FloorCell::kFree);
}

TEST(FloorGrid, NeedsSomethingToBeSeen) {
  const auto nothing = [](const auto&) { return Expected<void>(); };
  EXPECT_ERROR(make_floor_grid({}, {}, nothing), "nothing was seen");
  EXPECT_ERROR(make_floor_grid({}, {}, nothing, {.cell_m = 0}), "cell_m");
  EXPECT_ERROR(FloorGridOptions{.person_height_m = 0.3}.validate(), "person_height_m");
  EXPECT_ERROR(FloorGridOptions{.person_height_m = 1e6}.validate(), "at most 10");
  EXPECT_ERROR(FloorGridOptions{.step_m = 0}.validate(), "step_m");
  EXPECT_ERROR(FloorGridOptions{.min_empty = 2}.validate(), "min_empty");
}

}  // namespace
}  // namespace roomwise::fusion
