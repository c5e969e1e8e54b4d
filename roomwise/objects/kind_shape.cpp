#include "roomwise/objects/kind_shape.h"

#include <algorithm>
#include <array>

namespace roomwise::objects {
namespace {

constexpr double kAny = KindShape::kAny;
constexpr std::array kShapes = {
    // name, stands on the floor; at least: side, longest; at most: side, length, height; at least:
    // height, length; seldom lower; built in
    KindShape{"bath", true, 0.65, 1.2, 1.2, 2.4, 1.4},
    KindShape{"bed", true, 0.8, 0, 2.3, 2.5, 2.2, 0, 1.3},
    KindShape{"bookcase", true, 0.3, 0.7, 0.75, 4.0, 2.8},
    KindShape{"bottle", false, 0, 0, 0.2, 0.35, 0.55, 0.17},
    KindShape{"chair", true, 0.42, 0, 1.1, 1.2, 1.5, 0.4},
    // Kitchen cabinets are called fridges oftener than low fridges are.
    KindShape{"fridge", true, 0.65, 0, 1.1, 1.3, 2.4, 0.4, 0, 1.1},
    KindShape{"lamp", false, 0.1, 0, 0.9, 1.1, 2.2},
    KindShape{"laptop", false, 0, 0, 0.6, 0.7, 0.5},
    KindShape{"microwave", false, 0.35, 0, 0.75, 0.9, 0.7},
    KindShape{"sink", true, 0.4, 0, 1.0, 1.4, 1.3, 0.65},
    KindShape{"sofa", true, 0.8, 0, 2.4, 3.8, 1.5},
    KindShape{"stove", true, 0.55, 0, 1.0, 1.6, 1.5},
    KindShape{"table", true, 0.5, 0, 1.8, 3.5, 1.3},
    KindShape{"toaster", false, 0, 0, 0.5, 0.6, 0.5},
    KindShape{"toilet seat", true, 0.38, 0, 0.75, 1.05, 1.2, 0, 0.42},
    KindShape{"tv", false, 0, 0.45, 0.5, 2.2, 1.05, 0, 0.35},
    KindShape{"vase", false, 0, 0, 0.6, 0.6, 1.1},
    KindShape{"wardrobe", true, 0.58, 0.7, 1.45, 4.0, 2.8},
    KindShape{"washing machine", true, 0.58, 0.58, 1.0, 1.1, 1.3, 0, 0, 0, true},
};

bool is_at_most(const KindShape& shape, const Eigen::Vector3d& size_m) {
  return size_m.head<2>().minCoeff() <= shape.most_side_m &&
         size_m.head<2>().maxCoeff() <= shape.most_length_m && size_m.z() <= shape.most_height_m;
}

}  // namespace

bool KindShape::is_exceeded_by(const Eigen::Vector3d& size_m) const {
  return !is_at_most(*this, size_m);
}

bool KindShape::holds(const Eigen::Vector3d& size_m) const {
  return is_at_most(*this, size_m) && size_m.z() >= least_height_m &&
         size_m.head<2>().maxCoeff() >= least_length_m;
}

bool KindShape::holds_what_is_seen(const Eigen::Vector3d& seen_m) const {
  return seen_m.head<2>().minCoeff() >= (built_in ? 0 : 0.5 * least_side_m) &&
         seen_m.head<2>().maxCoeff() >= 0.9 * least_side_m &&
         seen_m.maxCoeff() >= least_longest_m &&
         is_at_most(*this, on_floor ? without_rim(seen_m) : seen_m);
}

KindShape shape_of(std::string_view name) {
  const auto found = std::ranges::find(kShapes, name, &KindShape::name);
  return found == kShapes.end() ? KindShape{.name = name} : *found;
}

}  // namespace roomwise::objects
