#include "laboratory/simulation/home/kitchen_row.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace roomwise::simulation {
namespace {

constexpr double kJoint = 0.022;  // between units; neighbours need a hand's breadth less
constexpr double kCorner = 0.03;
constexpr double kRowDepth = 0.7;
constexpr double kFreeBefore = 0.75;
constexpr double kWallCabinetBottom = 1.45;
constexpr double kHoodBottom = 1.62;
constexpr double kLongEnough = 3.6;

struct Stretch {
  WallSide side;
  double from_m = 0, to_m = 0;

  [[nodiscard]] double length() const { return to_m - from_m; }
};

// The longest part of a side where a row of units may stand.
Stretch longest_stretch(const RoomFurnisher& furnisher, const WallSide& side) {
  constexpr double kStep = 0.05;
  Stretch longest{side, 0, 0};
  double from = kCorner;
  const auto close = [&](double to) {
    if (to - from > longest.length()) longest = {side, from, to};
  };
  FurnitureModel probe;
  probe.size_m = {kStep, kRowDepth, 0.9};
  for (double along = kCorner; along + kStep <= side.length_m - kCorner; along += kStep) {
    if (!furnisher.fits(furnisher.against(probe, side, along + kStep / 2), kFreeBefore)) {
      close(along);
      from = along + kStep;
    }
  }
  close(side.length_m - kCorner);
  return longest;
}

bool is_blind(const RoomFurnisher& furnisher, const Stretch& stretch) {
  FurnitureModel probe;
  probe.size_m = {stretch.length(), 0.4, 2};
  const PlacedObject wide =
      furnisher.against(probe, stretch.side, (stretch.from_m + stretch.to_m) / 2);
  return !furnisher.covers_window(footprint_of(wide));
}

std::string_view author_of(const FurnitureModel& model) {
  return std::string_view(model.id).substr(0, model.id.find('/'));
}

using Units = std::vector<const FurnitureModel*>;

// Low cabinets, those first that were made for the same kitchen as the sink.
Units low_cabinets(RoomFurnisher& furnisher, const FurnitureModel* sink) {
  Units cabinets = furnisher.choose("kitchen_cabinet", 9, 1.0);
  std::ranges::stable_partition(cabinets, [&](const FurnitureModel* cabinet) {
    return sink != nullptr && author_of(*cabinet) == author_of(*sink);
  });
  return cabinets;
}

// From the corner to the row's end: sink and stove, with worktop between and beside them.
Units choose_units(RoomFurnisher& furnisher, double length) {
  Units units;
  double left = length;
  const auto take = [&](const Units& choice, std::size_t at) -> const FurnitureModel* {
    for (const FurnitureModel* unit : choice) {
      if (unit->size_m.x() + kJoint > left) continue;
      left -= unit->size_m.x() + kJoint;
      units.insert(units.begin() + static_cast<std::ptrdiff_t>(at), unit);
      return unit;
    }
    return nullptr;
  };
  const FurnitureModel* sink = take(furnisher.choose("sink"), 0);
  take(furnisher.choose("stove"), units.size());
  const Units cabinets = low_cabinets(furnisher, sink);
  take(cabinets, units.size() > 1 ? 1 : 0);  // between them
  constexpr int kMaxMore = 5;
  for (int i = 0; i < kMaxMore; ++i) {
    // By turns at the corner and at the far end, of the same make as the first.
    if (take(cabinets, i % 2 == 0 ? 0 : units.size()) == nullptr) break;
  }
  return units;
}

// The one of a kind that spans most of the width below it.
const FurnitureModel* widest_within(RoomFurnisher& furnisher, std::string_view kind, double width) {
  const FurnitureModel* widest = nullptr;
  for (const FurnitureModel* model : furnisher.choose(kind, width + 0.01)) {
    if (widest == nullptr || model->size_m.x() > widest->size_m.x() + 1e-9) widest = model;
  }
  return widest;
}

void add_above(RoomFurnisher& furnisher, const FurnitureModel& unit, const WallSide& side,
               double along) {
  const bool is_stove = unit.kind == "stove";
  const FurnitureModel* above = widest_within(furnisher, is_stove ? "hood" : "kitchen_wall_cabinet",
                                              unit.size_m.x() + (is_stove ? 0.1 : 0));
  if (above == nullptr) return;
  FurnitureModel hung = *above;
  hung.elevation_m = is_stove ? std::max(kHoodBottom, hung.elevation_m)
                              : std::max(kWallCabinetBottom, hung.elevation_m);
  furnisher.try_add(furnisher.against(hung, side, along), 0);
}

// Units side by side from one end of a stretch towards the other.
class Row {
 public:
  Row(RoomFurnisher& furnisher, const Stretch& stretch, bool begins_at_left)
      : furnisher_(furnisher),
        stretch_(stretch),
        begins_at_left_(begins_at_left),
        next_(begins_at_left ? stretch.from_m : stretch.to_m) {}

  [[nodiscard]] double left() const {
    return begins_at_left_ ? stretch_.to_m - next_ : next_ - stretch_.from_m;
  }

  bool put(const FurnitureModel& unit) {
    const double half = unit.size_m.x() / 2;
    const double direction = begins_at_left_ ? 1 : -1;
    const double along = next_ + direction * half;
    constexpr double kFreeBeforeUnit = 0.55;
    const PlacedObject placed = furnisher_.against(unit, stretch_.side, along);
    if (!furnisher_.try_add(placed, kFreeBeforeUnit)) return false;
    if (unit.kind != "fridge") add_above(furnisher_, unit, stretch_.side, along);
    next_ = along + direction * (half + kJoint);
    return true;
  }

  // In the corner, where sink, stove and a cabinet still find room beside it.
  bool put_fridge() {
    constexpr double kMinBeside = 1.9;
    const Units fridges = furnisher_.choose("fridge");
    return std::ranges::any_of(fridges, [&](const FurnitureModel* fridge) {
      return left() - fridge->size_m.x() >= kMinBeside && put(*fridge);
    });
  }

 private:
  RoomFurnisher& furnisher_;
  const Stretch& stretch_;
  bool begins_at_left_;
  double next_;
};

}  // namespace

void add_kitchen_row(RoomFurnisher& furnisher) {
  std::vector<Stretch> stretches;
  for (const WallSide& side : sides_of(furnisher.room().interior)) {
    stretches.push_back(longest_stretch(furnisher, side));
  }
  std::ranges::stable_sort(stretches, std::ranges::greater{}, [&](const Stretch& stretch) {
    // A wall without windows has room for cabinets above the row.
    return std::min(stretch.length(), kLongEnough) + (is_blind(furnisher, stretch) ? 0.7 : 0);
  });
  const Stretch& stretch = stretches.front();
  constexpr double kShortest = 1.2;
  if (stretch.length() < kShortest) return;

  const bool left_is_corner = stretch.from_m <= stretch.side.length_m - stretch.to_m;
  Row row(furnisher, stretch, left_is_corner), from_other_end(furnisher, stretch, !left_is_corner);
  const bool turned = !row.put_fridge() && from_other_end.put_fridge();
  Row& chosen = turned ? from_other_end : row;
  for (const FurnitureModel* unit : choose_units(furnisher, chosen.left())) chosen.put(*unit);
}

}  // namespace roomwise::simulation
