#include "roomwise/objects/proposals/furniture_form.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kCell_m = 0.05;

// Furniture of boards, in a frame of its own with the floor at 0, and what a map shows of it: the
// cells that its boards' surfaces cross, but for what faces the floor.
class Furniture {
 public:
  Furniture& board(const Vector3d& low, const Vector3d& high) {
    boards_.emplace_back(low, high);
    return *this;
  }
  Furniture& legs(double width_m, double depth_m, double height_m) {
    constexpr double kThick_m = 0.04;
    for (const double x : {0.0, width_m - kThick_m}) {
      for (const double y : {0.0, depth_m - kThick_m}) {
        board({x, y, 0}, {x + kThick_m, y + kThick_m, height_m});
      }
    }
    return *this;
  }

  [[nodiscard]] std::optional<FurnitureForm> form(double turn_rad = 0) const {
    const Vector3d away(3.02, -1.01, 0);
    const Eigen::AngleAxisd turn(turn_rad, Vector3d::UnitZ());
    std::set<std::tuple<int, int, int>> cells;
    const auto cell_of = [](double value_m) {
      return static_cast<int>(std::floor(value_m / kCell_m));
    };
    for (const Eigen::AlignedBox3d& board : boards_) {
      constexpr double kStep_m = 0.02;
      const Eigen::Array3i steps = (board.sizes().array() / kStep_m).ceil().cast<int>().max(1);
      for (int x = 0; x <= steps.x(); ++x) {
        for (int y = 0; y <= steps.y(); ++y) {
          for (int z = 0; z <= steps.z(); ++z) {
            const bool on_surface = x % steps.x() == 0 || y % steps.y() == 0 || z == steps.z();
            if (!on_surface) continue;
            const Vector3d place = board.min() + Vector3d(x, y, z)
                                                     .cwiseQuotient(steps.cast<double>().matrix())
                                                     .cwiseProduct(board.sizes());
            if (place.z() < 0.08) continue;  // taken for floor
            const Vector3d at = turn * place + away;
            cells.insert({cell_of(at.x()), cell_of(at.y()), cell_of(at.z())});
          }
        }
      }
    }
    std::vector<Vector3f> surface;
    for (const auto& [x, y, z] : cells) {
      surface.push_back(((Vector3d(x, y, z).array() + 0.5) * kCell_m).cast<float>());
    }
    return form_of(surface, kCell_m);
  }

 private:
  std::vector<Eigen::AlignedBox3d> boards_;
};

Furniture table(double height_m, double width_m = 1.2, double depth_m = 0.8) {
  return Furniture()
      .board({0, 0, height_m - 0.03}, {width_m, depth_m, height_m})
      .legs(width_m, depth_m, height_m);
}
Furniture chair() {
  return Furniture()
      .board({0, 0, 0.42}, {0.45, 0.45, 0.46})
      .board({0, 0.41, 0.46}, {0.45, 0.45, 0.9})
      .legs(0.45, 0.45, 0.42);
}
Furniture sofa() {
  return Furniture()
      .board({0, 0, 0.05}, {1.9, 0.85, 0.42})
      .board({0, 0.65, 0.42}, {1.9, 0.85, 0.8})
      .board({0, 0, 0.42}, {0.15, 0.85, 0.6})
      .board({1.75, 0, 0.42}, {1.9, 0.85, 0.6});
}
Furniture bed() {
  return Furniture().board({0, 0, 0.1}, {0.95, 2.0, 0.5}).board({0, 1.96, 0}, {0.95, 2.0, 0.95});
}

TEST(FormOf, TellsWhatPeopleSitAndEatAt) {
  EXPECT_EQ(table(0.74).form(), FurnitureForm::kTable);
  EXPECT_EQ(table(0.45, 1.1, 0.6).form(), FurnitureForm::kTable) << "before a sofa";
  EXPECT_EQ(chair().form(), FurnitureForm::kChair);
  EXPECT_EQ(sofa().form(), FurnitureForm::kSofa);
}

TEST(FormOf, AnArmchairIsAChair) {
  const Furniture armchair =
      Furniture().board({0, 0, 0.1}, {0.8, 0.8, 0.42}).board({0, 0.65, 0.42}, {0.8, 0.8, 0.85});
  EXPECT_EQ(armchair.form(), FurnitureForm::kChair);
}

TEST(FormOf, HangsOnNoDirection) {
  for (const double turn_rad : {0.3, 1.0, 2.2, -2.6}) {
    EXPECT_EQ(table(0.74).form(turn_rad), FurnitureForm::kTable) << turn_rad;
    EXPECT_EQ(chair().form(turn_rad), FurnitureForm::kChair) << turn_rad;
    EXPECT_EQ(sofa().form(turn_rad), FurnitureForm::kSofa) << turn_rad;
  }
}

TEST(FormOf, ABedHasItsHeadAtAShortSide) {
  EXPECT_EQ(bed().form(), std::nullopt);
}

TEST(FormOf, AShelfAtATablesHeightIsLessDeep) {
  EXPECT_EQ(table(0.74, 1.2, 0.5).form(), FurnitureForm::kTable);
  EXPECT_EQ(Furniture().board({0, 0, 0}, {1.2, 0.34, 0.74}).form(), std::nullopt);
}

TEST(FormOf, WhatHasSidesIsNoLowTable) {
  const Furniture chest = Furniture().board({0, 0, 0}, {1.1, 0.6, 0.45});
  EXPECT_EQ(chest.form(), std::nullopt);
}

TEST(FormOf, ALowTableWithAPileAlongOneSideIsNoSofa) {
  EXPECT_EQ(table(0.45, 1.4, 0.6).board({0.1, 0.45, 0.45}, {1.3, 0.6, 0.75}).form(), std::nullopt);
}

TEST(FormOf, AStoolWithABagOnItsMiddleIsNoChair) {
  EXPECT_EQ(Furniture()
                .board({0, 0, 0.42}, {0.45, 0.45, 0.46})
                .legs(0.45, 0.45, 0.42)
                .board({0.1, 0.12, 0.46}, {0.35, 0.33, 0.75})
                .form(),
            std::nullopt);
}

TEST(FormOf, AStoolHasNoBackAndASeatAboveThatOfPeopleIsNone) {
  const Furniture stool = Furniture().board({0, 0, 0.42}, {0.4, 0.4, 0.46}).legs(0.4, 0.4, 0.42);
  EXPECT_EQ(stool.form(), std::nullopt);
  const Furniture high = Furniture()
                             .board({0, 0, 0.8}, {0.45, 0.45, 0.84})
                             .board({0, 0.41, 0.84}, {0.45, 0.45, 1.1})
                             .legs(0.45, 0.45, 0.8);
  EXPECT_EQ(high.form(), std::nullopt);
}

TEST(FormOf, AWardrobeAndABookcaseHaveNone) {
  EXPECT_EQ(Furniture().board({0, 0, 0}, {1.2, 0.6, 2.0}).form(), std::nullopt);
  Furniture bookcase = Furniture().board({0, 0.28, 0}, {0.8, 0.3, 1.8});
  for (const double z : {0.1, 0.45, 0.8, 1.15, 1.5, 1.78}) {
    bookcase.board({0, 0, z}, {0.8, 0.3, z + 0.02});
  }
  EXPECT_EQ(bookcase.form(), std::nullopt);
}

}  // namespace
}  // namespace roomwise::objects
