#include "roomwise/objects/proposals/class_size_prior.h"

#include <algorithm>
#include <array>

namespace roomwise::objects {
namespace {

constexpr double kAny = ClassSizePrior::kAny;
constexpr std::array kShapes = {
    ClassSizePrior{.name = "bath",
                   .on_floor = true,
                   .min_side_m = 0.65,
                   .min_longest_m = 1.2,
                   .max_side_m = 1.2,
                   .max_length_m = 2.4,
                   .max_height_m = 1.4},
    ClassSizePrior{.name = "bed",
                   .on_floor = true,
                   .min_side_m = 0.8,
                   .max_side_m = 2.3,
                   .max_length_m = 2.5,
                   .max_height_m = 2.2,
                   .min_height_m = 0.2,
                   .min_length_m = 1.3},
    ClassSizePrior{.name = "bookcase",
                   .on_floor = true,
                   .min_side_m = 0.3,
                   .min_longest_m = 0.7,
                   .max_side_m = 0.75,
                   .max_length_m = 4.0,
                   .max_height_m = 2.8},
    ClassSizePrior{.name = "bottle",
                   .max_side_m = 0.2,
                   .max_length_m = 0.35,
                   .max_height_m = 0.55,
                   .min_height_m = 0.17},
    ClassSizePrior{.name = "chair",
                   .on_floor = true,
                   .min_side_m = 0.42,
                   .max_side_m = 1.1,
                   .max_length_m = 1.2,
                   .max_height_m = 1.5,
                   .min_height_m = 0.4},
    // Kitchen cabinets are called fridges oftener than low fridges are.
    ClassSizePrior{.name = "fridge",
                   .on_floor = true,
                   .min_side_m = 0.65,
                   .max_side_m = 1.1,
                   .max_length_m = 1.3,
                   .max_height_m = 2.4,
                   .min_height_m = 0.4,
                   .tall_m = 1.9,
                   .max_length_of_tall_m = 1.0},
    ClassSizePrior{.name = "lamp",
                   .min_side_m = 0.1,
                   .max_side_m = 0.9,
                   .max_length_m = 1.1,
                   .max_height_m = 2.2},
    ClassSizePrior{.name = "laptop", .max_side_m = 0.6, .max_length_m = 0.7, .max_height_m = 0.5},
    ClassSizePrior{.name = "microwave",
                   .min_side_m = 0.35,
                   .max_side_m = 0.75,
                   .max_length_m = 0.9,
                   .max_height_m = 0.7},
    ClassSizePrior{.name = "sink",
                   .on_floor = true,
                   .min_side_m = 0.4,
                   .max_side_m = 1.0,
                   .max_length_m = 1.4,
                   .max_height_m = 1.3,
                   .min_height_m = 0.65},
    ClassSizePrior{.name = "sofa",
                   .on_floor = true,
                   .min_side_m = 0.8,
                   .max_side_m = 2.4,
                   .max_length_m = 3.8,
                   .max_height_m = 1.5},
    ClassSizePrior{.name = "stove",
                   .on_floor = true,
                   .min_side_m = 0.55,
                   .max_side_m = 1.0,
                   .max_length_m = 1.6,
                   .max_height_m = 1.5},
    ClassSizePrior{.name = "table",
                   .on_floor = true,
                   .min_side_m = 0.5,
                   .max_side_m = 1.8,
                   .max_length_m = 3.0,
                   .max_height_m = 1.3},
    ClassSizePrior{.name = "toaster", .max_side_m = 0.5, .max_length_m = 0.6, .max_height_m = 0.5},
    ClassSizePrior{.name = "toilet seat",
                   .on_floor = true,
                   .min_side_m = 0.38,
                   .max_side_m = 0.75,
                   .max_length_m = 1.05,
                   .max_height_m = 1.2,
                   .min_length_m = 0.42},
    // Lower ones are mostly pictures, mirrors and hoods; few televisions are smaller than 27
    // inches.
    ClassSizePrior{.name = "tv",
                   .min_longest_m = 0.45,
                   .max_side_m = 0.5,
                   .max_length_m = 2.2,
                   .max_height_m = 1.05,
                   .min_height_m = 0.35,
                   .min_length_m = 0.35},
    ClassSizePrior{.name = "vase", .max_side_m = 0.6, .max_length_m = 0.6, .max_height_m = 1.1},
    ClassSizePrior{.name = "wardrobe",
                   .on_floor = true,
                   .min_side_m = 0.58,
                   .min_longest_m = 0.7,
                   .max_side_m = 1.45,
                   .max_length_m = 4.0,
                   .max_height_m = 2.8},
    ClassSizePrior{.name = "washing machine",
                   .on_floor = true,
                   .min_side_m = 0.58,
                   .min_longest_m = 0.58,
                   .max_side_m = 1.0,
                   .max_length_m = 1.1,
                   .max_height_m = 1.3,
                   .built_in = true},
};

bool is_at_most(const ClassSizePrior& shape, const Eigen::Vector3d& size_m) {
  return size_m.head<2>().minCoeff() <= shape.max_side_m &&
         size_m.head<2>().maxCoeff() <= shape.max_length_at(size_m.z()) &&
         size_m.z() <= shape.max_height_m;
}

}  // namespace

bool ClassSizePrior::holds(const Eigen::Vector3d& size_m) const {
  return is_at_most(*this, size_m) && size_m.z() >= min_height_m &&
         size_m.head<2>().maxCoeff() >= min_length_m;
}

bool ClassSizePrior::fits_when_partial(const Eigen::Vector3d& seen_m) const {
  return seen_m.head<2>().minCoeff() >= (built_in ? 0 : 0.5 * min_side_m) &&
         seen_m.head<2>().maxCoeff() >= 0.9 * min_side_m && seen_m.maxCoeff() >= min_longest_m &&
         is_at_most(*this, on_floor ? without_rim(seen_m) : seen_m);
}

ClassSizePrior size_prior_of(std::string_view name) {
  const auto found = std::ranges::find(kShapes, name, &ClassSizePrior::name);
  return found == kShapes.end() ? ClassSizePrior{.name = name} : *found;
}

}  // namespace roomwise::objects
