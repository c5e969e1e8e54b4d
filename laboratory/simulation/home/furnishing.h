#pragma once

#include <span>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Furniture, small things, pictures and lights for every room of a home that has none. Draws from
// the home's seed.
void furnish(HomeModel& home, std::span<const FurnitureModel> models);

// A lamp's light, off. The lamp is the object of that index.
[[nodiscard]] Light light_of_lamp(const HomeModel& home, std::size_t object);

// "chair 3": unique in the home, numbered where there are several.
void name_objects(HomeModel& home);

}  // namespace roomwise::simulation
