#include "roomwise/objects/kind_shape.h"

#include <algorithm>
#include <array>

namespace roomwise::objects {
namespace {

constexpr double kAny = KindShape::kAny;
constexpr std::array kShapes = {
    KindShape{.name = "bath",
              .on_floor = true,
              .least_side_m = 0.65,
              .least_longest_m = 1.2,
              .most_side_m = 1.2,
              .most_length_m = 2.4,
              .most_height_m = 1.4},
    KindShape{.name = "bed",
              .on_floor = true,
              .least_side_m = 0.8,
              .most_side_m = 2.3,
              .most_length_m = 2.5,
              .most_height_m = 2.2,
              .least_height_m = 0.2,
              .least_length_m = 1.3},
    KindShape{.name = "bookcase",
              .on_floor = true,
              .least_side_m = 0.3,
              .least_longest_m = 0.7,
              .most_side_m = 0.75,
              .most_length_m = 4.0,
              .most_height_m = 2.8},
    KindShape{.name = "bottle",
              .most_side_m = 0.2,
              .most_length_m = 0.35,
              .most_height_m = 0.55,
              .least_height_m = 0.17,
              .shows_foot_alone = true},
    KindShape{.name = "chair",
              .on_floor = true,
              .least_side_m = 0.42,
              .most_side_m = 1.1,
              .most_length_m = 1.2,
              .most_height_m = 1.5,
              .least_height_m = 0.4},
    // Kitchen cabinets are called fridges oftener than low fridges are.
    KindShape{.name = "fridge",
              .on_floor = true,
              .least_side_m = 0.65,
              .most_side_m = 1.1,
              .most_length_m = 1.3,
              .most_height_m = 2.4,
              .least_height_m = 0.4,
              .usual_height_m = 1.1,
              .tall_m = 1.9,
              .most_length_of_tall_m = 1.0},
    KindShape{.name = "lamp",
              .least_side_m = 0.1,
              .most_side_m = 0.9,
              .most_length_m = 1.1,
              .most_height_m = 2.2},
    KindShape{.name = "laptop", .most_side_m = 0.6, .most_length_m = 0.7, .most_height_m = 0.5},
    KindShape{.name = "microwave",
              .least_side_m = 0.35,
              .most_side_m = 0.75,
              .most_length_m = 0.9,
              .most_height_m = 0.7,
              .least_apart_m = 1},
    KindShape{.name = "sink",
              .on_floor = true,
              .least_side_m = 0.4,
              .most_side_m = 1.0,
              .most_length_m = 1.4,
              .most_height_m = 1.3,
              .least_height_m = 0.65},
    KindShape{.name = "sofa",
              .on_floor = true,
              .least_side_m = 0.8,
              .most_side_m = 2.4,
              .most_length_m = 3.8,
              .most_height_m = 1.5},
    KindShape{.name = "stove",
              .on_floor = true,
              .least_side_m = 0.55,
              .most_side_m = 1.0,
              .most_length_m = 1.6,
              .most_height_m = 1.5},
    KindShape{.name = "table",
              .on_floor = true,
              .least_side_m = 0.5,
              .most_side_m = 1.8,
              .most_length_m = 3.0,
              .most_height_m = 1.3},
    KindShape{.name = "toaster", .most_side_m = 0.5, .most_length_m = 0.6, .most_height_m = 0.5},
    KindShape{.name = "toilet seat",
              .on_floor = true,
              .least_side_m = 0.38,
              .most_side_m = 0.75,
              .most_length_m = 1.05,
              .most_height_m = 1.2,
              .least_length_m = 0.42},
    // Lower ones are mostly pictures, mirrors and hoods; few televisions are smaller than 27
    // inches.
    KindShape{.name = "tv",
              .least_longest_m = 0.45,
              .most_side_m = 0.5,
              .most_length_m = 2.2,
              .most_height_m = 1.05,
              .least_height_m = 0.35,
              .least_length_m = 0.35},
    KindShape{.name = "vase", .most_side_m = 0.6, .most_length_m = 0.6, .most_height_m = 1.1},
    KindShape{.name = "wardrobe",
              .on_floor = true,
              .least_side_m = 0.58,
              .least_longest_m = 0.7,
              .most_side_m = 1.45,
              .most_length_m = 4.0,
              .most_height_m = 2.8},
    KindShape{.name = "washing machine",
              .on_floor = true,
              .least_side_m = 0.58,
              .least_longest_m = 0.58,
              .most_side_m = 1.0,
              .most_length_m = 1.1,
              .most_height_m = 1.3,
              .built_in = true},
};

bool is_at_most(const KindShape& shape, const Eigen::Vector3d& size_m) {
  return size_m.head<2>().minCoeff() <= shape.most_side_m &&
         size_m.head<2>().maxCoeff() <= shape.most_length_at(size_m.z()) &&
         size_m.z() <= shape.most_height_m;
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
