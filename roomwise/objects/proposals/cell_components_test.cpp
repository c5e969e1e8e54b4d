#include "roomwise/objects/proposals/cell_components.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

namespace roomwise::objects {
namespace {

using Eigen::Vector3f;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Blocks of cells, in the order of their keys.
class Cells {
 public:
  // Its low corner and size, m.
  Cells& block(const Vector3f& low, const Vector3f& size) {
    const Eigen::Array3i count = (size / kLevelCell_m).array().round().cast<int>();
    for (int x = 0; x < count.x(); ++x) {
      for (int y = 0; y < count.y(); ++y) {
        for (int z = 0; z < count.z(); ++z) {
          const Vector3f middle =
              low + ((Eigen::Array3i(x, y, z).cast<float>() + 0.5F) * kLevelCell_m).matrix();
          cells_.push_back({voxel_of(middle, kLevelCell_m), middle, 2});
        }
      }
    }
    std::ranges::sort(cells_, {}, &LevelCell::key);
    return *this;
  }
  [[nodiscard]] const std::vector<LevelCell>& all() const { return cells_; }
  // Those whose middle lies in a block.
  [[nodiscard]] Component within(const Vector3f& low, const Vector3f& size) const {
    Component component;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const Eigen::Array3f at = cells_[i].middle - low;
      if ((at > 0).all() && (at < size.array()).all()) component.push_back(i);
    }
    return component;
  }

 private:
  std::vector<LevelCell> cells_;
};

const Vector3f kLowAt(0, 0, 0.1F), kLow(0.6F, 0.6F, 0.75F);
const Vector3f kHighAt(0.6F, 0, 0.1F), kHigh(0.9F, 0.6F, 1.9F);

TEST(PiecesApart, AreWhatNothingTouchesAboveSomeHeight) {
  Cells cells;
  cells.block(kLowAt, kLow).block(kHighAt, kHigh);
  const auto components = components_above(cells.all());
  ASSERT_FALSE(components.empty());
  EXPECT_EQ(components.front(), cells.within({0, 0, 0}, {3, 3, 3})) << "both, from below";
  const Component low = cells.within(kLowAt, kLow);
  const Component above = cells.within({0.6F, 0, 0.9F}, {0.9F, 0.6F, 1.1F});
  int of_high = 0;
  for (const Component& component : components) {
    EXPECT_FALSE(is_mostly_in(component, low)) << "it stands apart nowhere";
    if (is_mostly_in(component, above) && is_mostly_in(above, component)) ++of_high;
  }
  EXPECT_GE(of_high, 1);
}

TEST(PiecesApart, ThatHoldMostOfOneFromLowerDownAreThatOne) {
  Cells cells;
  cells.block({0, 0, 0.1F}, {0.6F, 0.6F, 0.4F});
  const auto from = [&](float low_m) { return cells.within({0, 0, low_m}, {1, 1, 1}); };
  EXPECT_THAT(components_above(cells.all()), ElementsAre(from(0.1F), from(0.3F), from(0.4F)))
      << "above 0.2 m are three quarters of it";
}

}  // namespace
}  // namespace roomwise::objects
