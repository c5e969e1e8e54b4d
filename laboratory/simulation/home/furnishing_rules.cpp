#include "laboratory/simulation/home/furnishing_rules.h"

#include <algorithm>

namespace roomwise::simulation {
namespace {

using enum Placing;

constexpr FurnitureRule kBedroomRules[] = {
    {.kind = "bed", .placing = kAgainstWall, .front_m = 0.5},
    {.kind = "nightstand", .placing = kBeside, .anchors = {"bed"}, .chance = 0.95},
    {.kind = "wardrobe", .placing = kAgainstWall, .front_m = 0.7},
    {.kind = "nightstand", .placing = kBeside, .anchors = {"bed"}, .most = 2, .chance = 0.85},
    {.kind = "radiator", .placing = kUnderWindow, .chance = 0.7},
    {.kind = "chest_of_drawers", .placing = kAgainstWall, .chance = 0.7, .front_m = 0.6},
    {.kind = "desk",
     .placing = kAgainstWall,
     .chance = 0.3,
     .front_m = 0.9,
     .max_width_m = 1.3,
     .min_room_m2 = 12},
    {.kind = "chair", .placing = kBefore, .anchors = {"desk"}, .chance = 0.9},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"nightstand"}, .most = 1},
    {.kind = "lamp",
     .placing = kOnTop,
     .anchors = {"nightstand", "chest_of_drawers"},
     .most = 2,
     .chance = 0.5},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"chest_of_drawers", "desk"}},
    {.kind = "chest", .placing = kAgainstWall, .chance = 0.15, .front_m = 0.5, .min_room_m2 = 13},
    {.kind = "chair", .placing = kAgainstWall, .chance = 0.5, .front_m = 0.3},
    {.kind = "bookcase",
     .placing = kAgainstWall,
     .chance = 0.3,
     .front_m = 0.5,
     .max_width_m = 1.1,
     .min_room_m2 = 12},
    {.kind = "rug", .placing = kOnFloor, .anchors = {"bed"}, .chance = 0.6},
    {.kind = "plant", .placing = kInCorner, .chance = 0.5},
    {.kind = "bin", .placing = kInCorner, .chance = 0.35},
    {.kind = "box", .placing = kInCorner, .chance = 0.2},
    {.kind = "bag", .placing = kInCorner, .chance = 0.25, .max_width_m = 0.5},
    {.kind = "shoes", .placing = kAgainstWall, .chance = 0.5},
    {.kind = "toy",
     .placing = kOnTop,
     .anchors = {"bed", "chest_of_drawers"},
     .chance = 0.3,
     .max_width_m = 0.4},
    {.kind = "clothes",
     .placing = kOnTop,
     .anchors = {"bed", "chair", "chest_of_drawers"},
     .chance = 0.4},
    {.kind = "book",
     .placing = kOnTop,
     .anchors = {"nightstand", "chest_of_drawers", "bed", "desk"},
     .most = 3,
     .chance = 0.6},
    {.kind = "small_plant",
     .placing = kOnTop,
     .anchors = {"chest_of_drawers", "desk"},
     .chance = 0.5,
     .max_width_m = 0.4},
    {.kind = "vase", .placing = kOnTop, .anchors = {"chest_of_drawers", "chest"}, .chance = 0.4},
    {.kind = "cup", .placing = kOnTop, .anchors = {"nightstand", "desk"}, .chance = 0.4},
    {.kind = "clock",
     .placing = kOnTop,
     .anchors = {"nightstand", "chest_of_drawers"},
     .chance = 0.3,
     .max_height_m = 0.3},
    {.kind = "radio", .placing = kOnTop, .anchors = {"chest_of_drawers", "desk"}, .chance = 0.2},
};

constexpr FurnitureRule kKitchenRules[] = {
    {.kind = "sink", .placing = kAgainstWall, .front_m = 0.6},
    {.kind = "fridge", .placing = kInCorner, .front_m = 0.7},
    {.kind = "stove", .placing = kAgainstWall, .front_m = 0.7},
    {.kind = "kitchen_cabinet", .placing = kAgainstWall, .front_m = 0.6, .max_height_m = 1},
    {.kind = "microwave", .placing = kOnTop, .anchors = {"kitchen_cabinet"}},
    {.kind = "dining_table",
     .placing = kInMiddle,
     .chance = 0.8,
     .front_m = 0.7,
     .max_width_m = 1.45,
     .min_room_m2 = 10},
    {.kind = "dining_table", .placing = kAgainstWall, .front_m = 0.65, .max_width_m = 1.25},
    {.kind = "microwave", .placing = kOnTop, .anchors = {"dining_table", "fridge"}},
    {.kind = "chair", .placing = kAround, .anchors = {"dining_table"}, .most = 4, .chance = 0.85},
    {.kind = "radiator", .placing = kUnderWindow, .chance = 0.5},
    {.kind = "washing_machine", .placing = kAgainstWall, .chance = 0.25, .front_m = 0.6},
    {.kind = "bin", .placing = kInCorner, .chance = 0.8},
    {.kind = "stool", .placing = kAgainstWall, .chance = 0.2, .front_m = 0.2},
    {.kind = "plant", .placing = kInCorner, .chance = 0.25, .max_width_m = 0.65},
    {.kind = "kettle", .placing = kOnTop, .anchors = {"kitchen_cabinet"}, .chance = 0.8},
    {.kind = "toaster", .placing = kOnTop, .anchors = {"kitchen_cabinet"}, .chance = 0.6},
    {.kind = "coffee_maker", .placing = kOnTop, .anchors = {"kitchen_cabinet"}, .chance = 0.5},
    {.kind = "knife_block", .placing = kOnTop, .anchors = {"kitchen_cabinet"}, .chance = 0.5},
    {.kind = "chopping_board", .placing = kOnTop, .anchors = {"kitchen_cabinet"}, .chance = 0.5},
    {.kind = "fruit",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .chance = 0.6},
    {.kind = "bread",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .chance = 0.4},
    {.kind = "bottle",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .most = 3,
     .chance = 0.6},
    {.kind = "cup",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .most = 4,
     .chance = 0.6},
    {.kind = "teapot",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .chance = 0.4},
    {.kind = "bowl",
     .placing = kOnTop,
     .anchors = {"dining_table", "kitchen_cabinet"},
     .chance = 0.5},
    {.kind = "book", .placing = kOnTop, .anchors = {"dining_table"}, .chance = 0.3},
};

constexpr FurnitureRule kToiletRules[] = {
    {.kind = "toilet", .placing = kAgainstWall, .front_m = 0.5},
    {.kind = "washbasin", .placing = kAgainstWall, .front_m = 0.5, .max_width_m = 0.95},
    {.kind = "bathtub", .placing = kInCorner, .chance = 0.65, .max_width_m = 1.85},
    {.kind = "shower",
     .placing = kInCorner,
     .front_m = 0.4,
     .min_depth_m = 0.6,
     .unless = "bathtub"},
    {.kind = "washing_machine", .placing = kAgainstWall, .chance = 0.5, .front_m = 0.5},
    {.kind = "bin", .placing = kInCorner, .chance = 0.7, .max_width_m = 0.35},
    {.kind = "toilet_paper", .placing = kBeside, .anchors = {"toilet"}, .chance = 0.9},
    {.kind = "towel", .placing = kAgainstWall, .chance = 0.7},
    {.kind = "radiator", .placing = kAgainstWall, .chance = 0.5, .max_width_m = 0.7},
    {.kind = "rug",
     .placing = kOnFloor,
     .anchors = {"bathtub", "shower", "washbasin"},
     .chance = 0.6,
     .max_width_m = 0.8},
    {.kind = "bottle", .placing = kOnTop, .anchors = {"washing_machine"}, .chance = 0.5},
    {.kind = "clothes", .placing = kOnTop, .anchors = {"washing_machine"}, .chance = 0.5},
    {.kind = "small_plant",
     .placing = kOnTop,
     .anchors = {"washing_machine"},
     .chance = 0.3,
     .max_width_m = 0.35},
};

constexpr FurnitureRule kLivingRoomRules[] = {
    {.kind = "sofa", .placing = kAgainstWall, .front_m = 1.1},
    {.kind = "tv_stand", .placing = kOpposite, .anchors = {"sofa"}, .front_m = 0.7},
    {.kind = "tv", .placing = kOnTop, .anchors = {"tv_stand"}},
    {.kind = "coffee_table", .placing = kAlong, .anchors = {"sofa"}, .chance = 0.85},
    {.kind = "rug", .placing = kOnFloor, .anchors = {"sofa"}, .chance = 0.7, .min_depth_m = 1.0},
    {.kind = "radiator", .placing = kUnderWindow, .most = 2, .chance = 0.6},
    {.kind = "bookcase", .placing = kAgainstWall, .most = 2, .chance = 0.75, .front_m = 0.6},
    {.kind = "armchair", .placing = kAgainstWall, .most = 2, .chance = 0.7, .front_m = 0.5},
    {.kind = "chest_of_drawers", .placing = kAgainstWall, .chance = 0.4, .front_m = 0.6},
    {.kind = "piano", .placing = kAgainstWall, .chance = 0.15, .front_m = 0.8, .min_room_m2 = 20},
    {.kind = "floor_lamp", .placing = kInCorner, .chance = 0.6},
    {.kind = "plant", .placing = kInCorner, .most = 2, .chance = 0.75},
    {.kind = "dining_table",
     .placing = kInMiddle,
     .chance = 0.4,
     .front_m = 0.75,
     .max_width_m = 1.5,
     .min_room_m2 = 20},
    {.kind = "chair", .placing = kAround, .anchors = {"dining_table"}, .most = 4, .chance = 0.85},
    {.kind = "footrest", .placing = kInMiddle, .chance = 0.15, .front_m = 0.45},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"chest_of_drawers", "chest"}, .chance = 0.8},
    {.kind = "bin", .placing = kInCorner, .chance = 0.25, .max_width_m = 0.4},
    {.kind = "cat", .placing = kAgainstWall, .chance = 0.08},
    {.kind = "book",
     .placing = kOnTop,
     .anchors = {"coffee_table", "chest_of_drawers", "dining_table", "sofa"},
     .most = 4,
     .chance = 0.65},
    {.kind = "cup",
     .placing = kOnTop,
     .anchors = {"coffee_table", "dining_table"},
     .most = 3,
     .chance = 0.5},
    {.kind = "laptop",
     .placing = kOnTop,
     .anchors = {"coffee_table", "dining_table", "sofa"},
     .chance = 0.4},
    {.kind = "vase",
     .placing = kOnTop,
     .anchors = {"coffee_table", "chest_of_drawers", "dining_table", "tv_stand"},
     .most = 2,
     .chance = 0.6},
    {.kind = "small_plant",
     .placing = kOnTop,
     .anchors = {"coffee_table", "chest_of_drawers", "dining_table", "tv_stand"},
     .chance = 0.5,
     .max_width_m = 0.45},
    {.kind = "fruit",
     .placing = kOnTop,
     .anchors = {"dining_table", "coffee_table"},
     .chance = 0.4},
    {.kind = "toy",
     .placing = kOnTop,
     .anchors = {"sofa", "armchair", "coffee_table"},
     .chance = 0.3,
     .max_width_m = 0.4},
};

constexpr FurnitureRule kDiningRoomRules[] = {
    {.kind = "dining_table", .placing = kInMiddle, .front_m = 0.8},
    {.kind = "dining_table", .placing = kAgainstWall, .front_m = 0.7},
    {.kind = "chair", .placing = kAround, .anchors = {"dining_table"}, .most = 6, .chance = 0.95},
    {.kind = "radiator", .placing = kUnderWindow, .chance = 0.6},
    {.kind = "bookcase", .placing = kAgainstWall, .chance = 0.5, .front_m = 0.5},
    {.kind = "chest_of_drawers", .placing = kAgainstWall, .chance = 0.8, .front_m = 0.5},
    {.kind = "chest", .placing = kAgainstWall, .chance = 0.3, .front_m = 0.5},
    {.kind = "floor_lamp", .placing = kInCorner, .chance = 0.4},
    {.kind = "plant", .placing = kInCorner, .most = 2, .chance = 0.7},
    {.kind = "rug", .placing = kOnFloor, .chance = 0.3, .min_depth_m = 1.0},
    {.kind = "vase",
     .placing = kOnTop,
     .anchors = {"dining_table", "chest_of_drawers", "chest"},
     .most = 2,
     .chance = 0.7},
    {.kind = "fruit", .placing = kOnTop, .anchors = {"dining_table"}, .chance = 0.6},
    {.kind = "bottle", .placing = kOnTop, .anchors = {"dining_table"}, .most = 2, .chance = 0.5},
    {.kind = "bowl",
     .placing = kOnTop,
     .anchors = {"dining_table", "chest_of_drawers"},
     .chance = 0.5},
    {.kind = "cup", .placing = kOnTop, .anchors = {"dining_table"}, .most = 4, .chance = 0.5},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"chest_of_drawers", "chest"}, .chance = 0.6},
    {.kind = "small_plant",
     .placing = kOnTop,
     .anchors = {"chest_of_drawers", "chest"},
     .chance = 0.5,
     .max_width_m = 0.45},
};

constexpr FurnitureRule kHallRules[] = {
    {.kind = "coat_rack", .placing = kAgainstWall, .front_m = 0.6},
    {.kind = "chest_of_drawers",
     .placing = kAgainstWall,
     .chance = 0.6,
     .front_m = 0.6,
     .max_width_m = 1.3},
    {.kind = "bookcase",
     .placing = kAgainstWall,
     .chance = 0.3,
     .front_m = 0.7,
     .max_width_m = 1.1,
     .min_room_m2 = 9},
    {.kind = "rug", .placing = kOnFloor, .chance = 0.7, .max_width_m = 0.9},
    {.kind = "radiator", .placing = kAgainstWall, .chance = 0.4, .max_width_m = 0.7},
    {.kind = "shoes", .placing = kAgainstWall, .most = 3, .chance = 0.7},
    {.kind = "plant", .placing = kInCorner, .chance = 0.4, .max_width_m = 0.5},
    {.kind = "bag", .placing = kAgainstWall, .chance = 0.4, .max_width_m = 0.5},
    {.kind = "stool", .placing = kAgainstWall, .chance = 0.3},
    {.kind = "vase", .placing = kOnTop, .anchors = {"chest_of_drawers"}, .chance = 0.6},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"chest_of_drawers"}, .chance = 0.4},
};

constexpr FurnitureRule kStudyRules[] = {
    {.kind = "desk", .placing = kAgainstWall, .front_m = 1.0},
    {.kind = "office_chair", .placing = kBefore, .anchors = {"desk"}},
    {.kind = "bookcase", .placing = kAgainstWall, .most = 2, .chance = 0.85, .front_m = 0.6},
    {.kind = "radiator", .placing = kUnderWindow, .chance = 0.6},
    {.kind = "computer", .placing = kOnTop, .anchors = {"desk"}, .chance = 0.6},
    {.kind = "laptop", .placing = kOnTop, .anchors = {"desk"}, .chance = 0.5},
    {.kind = "lamp", .placing = kOnTop, .anchors = {"desk"}},
    {.kind = "armchair", .placing = kAgainstWall, .chance = 0.5, .front_m = 0.5},
    {.kind = "chest_of_drawers",
     .placing = kAgainstWall,
     .chance = 0.5,
     .front_m = 0.5,
     .max_width_m = 0.9},
    {.kind = "shelf", .placing = kAgainstWall, .chance = 0.3, .front_m = 0.5},
    {.kind = "floor_lamp", .placing = kInCorner, .chance = 0.35},
    {.kind = "plant", .placing = kInCorner, .chance = 0.6},
    {.kind = "bin", .placing = kInCorner, .chance = 0.8, .max_width_m = 0.4},
    {.kind = "box", .placing = kInCorner, .chance = 0.4},
    {.kind = "rug", .placing = kOnFloor, .chance = 0.3},
    {.kind = "book",
     .placing = kOnTop,
     .anchors = {"desk", "chest_of_drawers"},
     .most = 4,
     .chance = 0.7},
    {.kind = "cup", .placing = kOnTop, .anchors = {"desk"}, .chance = 0.6},
    {.kind = "small_plant",
     .placing = kOnTop,
     .anchors = {"desk", "chest_of_drawers"},
     .chance = 0.5,
     .max_width_m = 0.35},
    {.kind = "radio", .placing = kOnTop, .anchors = {"chest_of_drawers", "desk"}, .chance = 0.3},
};

constexpr std::string_view kBedroomEssentials[] = {"bed", "wardrobe", "lamp"};
constexpr std::string_view kKitchenEssentials[] = {"fridge", "stove", "sink", "microwave"};
constexpr std::string_view kToiletEssentials[] = {"toilet", "washbasin"};
constexpr std::string_view kLivingRoomEssentials[] = {"sofa", "tv"};
constexpr std::string_view kDiningRoomEssentials[] = {"dining_table", "chair"};
constexpr std::string_view kStudyEssentials[] = {"desk", "office_chair"};

constexpr std::string_view kSmallKinds[] = {
    "book",         "bottle", "bowl",    "bread",  "chopping_board", "clock",  "clothes",
    "coffee_maker", "cup",    "fruit",   "kettle", "knife_block",    "laptop", "radio",
    "small_plant",  "teapot", "toaster", "toy",    "vase",
};
constexpr std::string_view kMovableKinds[] = {
    "bag",        "bin",      "box",  "cat",          "chair", "dog",
    "floor_lamp", "footrest", "lamp", "office_chair", "shoes", "stool",
};

}  // namespace

std::span<const FurnitureRule> furniture_rules(RoomKind room) {
  switch (room) {
    case RoomKind::kBedroom:
      return kBedroomRules;
    case RoomKind::kKitchen:
      return kKitchenRules;
    case RoomKind::kToilet:
      return kToiletRules;
    case RoomKind::kLivingRoom:
      return kLivingRoomRules;
    case RoomKind::kDiningRoom:
      return kDiningRoomRules;
    case RoomKind::kStudy:
      return kStudyRules;
    case RoomKind::kHall:
      break;
  }
  return kHallRules;
}

std::span<const std::string_view> essential_kinds(RoomKind room) {
  switch (room) {
    case RoomKind::kBedroom:
      return kBedroomEssentials;
    case RoomKind::kKitchen:
      return kKitchenEssentials;
    case RoomKind::kToilet:
      return kToiletEssentials;
    case RoomKind::kLivingRoom:
      return kLivingRoomEssentials;
    case RoomKind::kDiningRoom:
      return kDiningRoomEssentials;
    case RoomKind::kStudy:
      return kStudyEssentials;
    case RoomKind::kHall:
      break;
  }
  return {};
}

bool is_small_kind(std::string_view kind) {
  return std::ranges::find(kSmallKinds, kind) != std::end(kSmallKinds);
}

bool is_movable_kind(std::string_view kind) {
  return std::ranges::find(kMovableKinds, kind) != std::end(kMovableKinds);
}

}  // namespace roomwise::simulation
