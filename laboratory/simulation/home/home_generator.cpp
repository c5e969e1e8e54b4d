#include "laboratory/simulation/home/home_generator.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "laboratory/simulation/home/floor_plan.h"
#include "laboratory/simulation/home/furnishing.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/simulation/home/twins.h"

namespace roomwise::simulation {
namespace {

constexpr std::array<std::string_view, 7> kReferenceKinds{
    "bed", "lamp", "wardrobe", "microwave", "stove", "fridge", "toilet"};

// Models of the seven that networks know from all sides.
constexpr std::array<std::string_view, 7> kReferenceModels{
    "blendswap-cc-0/bed1",       "scopia/little_lamp1",        "blendswap-cc-by/wardrobe2",
    "blendswap-cc-by/microwave", "blendswap-cc-by/largeStove", "blendswap-cc-0/refrigerator",
    "blendswap-cc-0/toiletsUnit"};

// What would be taken for one of the seven.
constexpr std::array<std::string_view, 2> kLookAlikes{"floor_lamp", "washing_machine"};

bool is_reference_kind(std::string_view kind) {
  return std::ranges::find(kReferenceKinds, kind) != kReferenceKinds.end();
}

bool is_reference_model(std::string_view id) {
  return std::ranges::find(kReferenceModels, id) != kReferenceModels.end();
}

// All models but, of the seven kinds, the chosen ones where there are such.
std::vector<FurnitureModel> reference_models(std::span<const FurnitureModel> models) {
  std::vector<FurnitureModel> kept;
  for (const FurnitureModel& model : models) {
    if (std::ranges::find(kLookAlikes, model.kind) != kLookAlikes.end()) continue;
    const bool has_chosen = std::ranges::any_of(models, [&](const FurnitureModel& other) {
      return other.kind == model.kind && is_reference_model(other.id);
    });
    if (is_reference_kind(model.kind) && has_chosen && !is_reference_model(model.id)) continue;
    kept.push_back(model);
  }
  return kept;
}

bool has_each_once(const HomeModel& home) {
  return std::ranges::all_of(kReferenceKinds, [&](std::string_view kind) {
    return std::ranges::count(home.objects, kind, &PlacedObject::kind) == 1;
  });
}

}  // namespace

Expected<void> HomeOptions::validate() const {
  if (storeys != 1 && storeys != 2) return fail("storeys is {}; expected 1 or 2", storeys);
  if (storeys == 2 && (furniture_seed || finish_seed || mirrored)) {
    return fail(
        "storeys is 2: only homes of one storey have others of the same plan; leave out "
        "furniture_seed, finish_seed and mirrored");
  }
  return {};
}

Expected<HomeModel> generate_home(const HomeOptions& options,
                                  std::span<const FurnitureModel> models) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (options.storeys == 2) return generate_two_storeys(options, models);
  ROOMWISE_TRY(HomeModel home, plan_floor(options.seed, options.rooms));
  if (options.finish_seed) home = with_other_finishes(std::move(home), *options.finish_seed);
  if (options.mirrored) home = mirrored(std::move(home));
  home.seed = options.furniture_seed.value_or(options.seed);
  furnish(home, models);
  return apply_scenario(std::move(home), Scenario::kDay, home.seed, models);
}

Expected<HomeModel> generate_home(const HomeOptions& options, const FurnitureCatalogue& catalogue) {
  return generate_home(options, catalogue.models());
}

std::span<const std::string_view> reference_kinds() {
  return kReferenceKinds;
}

Expected<HomeModel> reference_flat(std::span<const FurnitureModel> models) {
  for (const std::string_view kind : kReferenceKinds) {
    if (std::ranges::count(models, kind, &FurnitureModel::kind) == 0) {
      return fail("the reference flat needs a {}, and the furniture has no model of one", kind);
    }
  }
  const std::vector<FurnitureModel> chosen = reference_models(models);
  HomeOptions options;
  options.rooms = {RoomKind::kHall, RoomKind::kBedroom, RoomKind::kKitchen, RoomKind::kToilet};
  // The first home in which each of the seven found one place.
  constexpr std::uint64_t kFirstSeed = 106, kMaxTries = 500;
  for (std::uint64_t i = 0; i < kMaxTries; ++i) {
    options.seed = kFirstSeed + i;
    ROOMWISE_TRY(HomeModel home, generate_home(options, chosen));
    if (has_each_once(home)) return home;
  }
  return fail(
      "no flat was found in which bed, lamp, wardrobe, microwave, stove, fridge and toilet "
      "have room; give smaller models");
}

Expected<HomeModel> reference_flat(const FurnitureCatalogue& catalogue) {
  return reference_flat(catalogue.models());
}

}  // namespace roomwise::simulation
