#include "roomwise/objects/proposals/furniture_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "roomwise/objects/instances/upright_box.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct Range {
  double least = 0, most = 0;
  [[nodiscard]] bool holds(double value) const { return value >= least && value <= most; }
};

// A surface in cells, over the columns of its footprint.
class Form {
 public:
  Form(std::span<const Vector3f> cells, double cell_m) : cell_m_(cell_m), cells_(cells.size()) {
    const geometry::OrientedBox box = upright_box(cells, Vector3d::UnitZ());
    const geometry::RigidTransform box_from_gravity = box.world_from_box.inverse();
    size_m_ = box.size_m.array() + cell_m;
    top_m_ = box.center().z() + size_m_.z() / 2;
    std::map<int, std::size_t> cells_at;  // by layer
    const auto index = [&](double value_m) {
      return static_cast<int>(std::floor(value_m / cell_m));
    };
    for (const Vector3f& cell : cells) {
      const Vector3d middle = cell.cast<double>();
      const Eigen::Vector2d in_box = (box_from_gravity * middle).head<2>();
      Column& column = columns_[{index(middle.x()), index(middle.y())}];
      column.in_box = in_box;
      column.heights_m.push_back(middle.z());
      places_.push_back({in_box, middle.z()});
      ++cells_at[index(middle.z())];
    }
    const auto fullest =
        std::ranges::max_element(cells_at, {}, [](const auto& one) { return one.second; });
    plane_m_ = (fullest->first + 0.5) * cell_m;
  }

  // The height of the fullest level layer, and how much of the footprint it covers. A level surface
  // between two layers is in both.
  [[nodiscard]] double plane_m() const { return plane_m_; }
  [[nodiscard]] double plane_m2() const {
    const auto level_columns = std::ranges::count_if(columns_, [&](const auto& column) {
      return std::ranges::any_of(column.second.heights_m, [&](double height_m) {
        return std::abs(height_m - plane_m_) < 1.5 * cell_m_ + 1e-6;
      });
    });
    return static_cast<double>(level_columns) * cell_m_ * cell_m_;
  }
  [[nodiscard]] double columns_m2() const {
    return static_cast<double>(columns_.size()) * cell_m_ * cell_m_;
  }
  [[nodiscard]] double footprint_m2() const { return size_m_.x() * size_m_.y(); }
  [[nodiscard]] double shorter_m() const { return size_m_.head<2>().minCoeff(); }
  [[nodiscard]] double longer_m() const { return size_m_.head<2>().maxCoeff(); }
  [[nodiscard]] double height_m() const { return size_m_.z(); }
  [[nodiscard]] double top_m() const { return top_m_; }
  [[nodiscard]] std::size_t cells() const { return cells_; }

  // The share of the columns at the rim of the footprint with something below the level surface:
  // much where it has sides, little where it stands on legs.
  [[nodiscard]] double side_share() const {
    constexpr double kRim_m = 0.1, kBelow_m = 0.15;
    int rim = 0, filled = 0;
    for (const auto& [index, column] : columns_) {
      const Eigen::Array2d to_side_m = size_m_.head<2>().array() / 2 - column.in_box.array().abs();
      if (to_side_m.minCoeff() > kRim_m) continue;
      ++rim;
      if (std::ranges::min(column.heights_m) < plane_m_ - kBelow_m) ++filled;
    }
    return rim == 0 ? 0 : static_cast<double>(filled) / rim;
  }

  // The cells that rise above the level surface, and those of them along each side of the box: the
  // two long ones first.
  struct Rising {
    std::size_t all = 0;
    std::array<std::size_t, 4> along_side{};
  };
  [[nodiscard]] Rising rising() const {
    constexpr double kAbove_m = 0.12, kMaxOfSide = 0.4;
    const double of_long_side_m = std::min(0.2, shorter_m() * kMaxOfSide);
    const double of_short_side_m = std::min(0.25, longer_m() * kMaxOfSide);
    const int longer = size_m_.x() > size_m_.y() ? 0 : 1;
    Rising rising;
    for (const auto& [place, height_m] : places_) {
      if (height_m < plane_m_ + kAbove_m) continue;
      ++rising.all;
      const double across_m = place[1 - longer], along_m = place[longer];
      if (size_m_[1 - longer] / 2 - std::abs(across_m) < of_long_side_m) {
        ++rising.along_side[across_m > 0 ? 0 : 1];
      }
      if (size_m_[longer] / 2 - std::abs(along_m) < of_short_side_m) {
        ++rising.along_side[along_m > 0 ? 2 : 3];
      }
    }
    return rising;
  }

 private:
  struct Place {
    Eigen::Vector2d in_box;
    double height_m;
  };
  struct Column {
    Eigen::Vector2d in_box;
    std::vector<double> heights_m;
  };
  double cell_m_;
  std::size_t cells_;
  Vector3d size_m_;
  double top_m_ = 0, plane_m_ = 0;
  std::vector<Place> places_;
  std::map<std::pair<int, int>, Column> columns_;
};

constexpr Range kSeatHeight_m{0.35, 0.56};  // of armchairs to kitchen chairs, with cushions

bool is_high_table(const Form& form) {
  constexpr Range kTop_m{0.62, 0.80};
  constexpr double kMin_m2 = 0.25, kMaxOfIt = 0.6;
  constexpr double kMinSide_m = 0.41;  // a shelf is less deep
  return kTop_m.holds(form.plane_m()) && form.plane_m2() >= kMin_m2 &&
         form.plane_m2() >= kMaxOfIt * form.columns_m2() && form.shorter_m() >= kMinSide_m;
}

// Beds, sofas and stools have sides where it has legs, and it bears little.
bool is_low_table(const Form& form) {
  constexpr Range kTop_m{0.33, 0.61}, kArea_m2{0.3, 1.3};
  constexpr double kMaxOfIt = 0.65, kMaxSide = 0.2, kMaxRising = 0.1, kMinSide_m = 0.45,
                   kMaxAbove_m = 0.45, kMinHeight_m = 0.2;
  return kTop_m.holds(form.plane_m()) && kArea_m2.holds(form.plane_m2()) &&
         form.plane_m2() >= kMaxOfIt * form.footprint_m2() && form.side_share() <= kMaxSide &&
         static_cast<double>(form.rising().all) <= kMaxRising * static_cast<double>(form.cells()) &&
         form.shorter_m() >= kMinSide_m && form.top_m() <= form.plane_m() + kMaxAbove_m &&
         form.height_m() >= kMinHeight_m;
}

bool is_chair(const Form& form) {
  constexpr Range kSide_m{0.38, 1.1}, kTop_m{0.62, 1.22}, kSeat_m2{0.1, 0.9};
  constexpr double kMaxShorter_m = 1.0, kMinRising = 0.08, kAlongOneSide = 0.75;
  constexpr std::size_t kFewestRising = 15;
  if (!kSide_m.holds(form.shorter_m()) || form.shorter_m() > kMaxShorter_m ||
      !kSide_m.holds(form.longer_m()) || !kTop_m.holds(form.top_m()) ||
      !kSeatHeight_m.holds(form.plane_m()) || !kSeat_m2.holds(form.plane_m2())) {
    return false;
  }
  const Form::Rising rising = form.rising();
  const auto back = static_cast<double>(std::ranges::max(rising.along_side));
  return rising.all >= kFewestRising &&
         static_cast<double>(rising.all) >= kMinRising * static_cast<double>(form.cells()) &&
         back >= kAlongOneSide * static_cast<double>(rising.all);
}

// A bed's head is along one of its short sides.
bool is_sofa(const Form& form) {
  constexpr Range kDepth_m{0.55, 1.05}, kLength_m{1.3, 2.7}, kTop_m{0.65, 1.05};
  constexpr double kMinSeat_m2 = 0.45, kMinSide = 0.15, kMinRising = 0.1, kAlongOneSide = 0.4,
                   kOfOther = 2;
  if (!kDepth_m.holds(form.shorter_m()) || !kLength_m.holds(form.longer_m()) ||
      !kTop_m.holds(form.top_m()) || !kSeatHeight_m.holds(form.plane_m()) ||
      form.plane_m2() < kMinSeat_m2 || form.side_share() < kMinSide) {
    return false;
  }
  const Form::Rising rising = form.rising();
  const auto back = static_cast<double>(std::max(rising.along_side[0], rising.along_side[1]));
  const auto front = static_cast<double>(std::min(rising.along_side[0], rising.along_side[1]));
  return static_cast<double>(rising.all) >= kMinRising * static_cast<double>(form.cells()) &&
         back >= kAlongOneSide * static_cast<double>(rising.all) && back > kOfOther * front;
}

}  // namespace

std::optional<FurnitureForm> form_of(std::span<const Vector3f> cells, double cell_m) {
  const Form form(cells, cell_m);
  if (is_high_table(form) || is_low_table(form)) return FurnitureForm::kTable;
  if (is_chair(form)) return FurnitureForm::kChair;
  if (is_sofa(form)) return FurnitureForm::kSofa;
  return std::nullopt;
}

}  // namespace roomwise::objects
