#pragma once

#include <string>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"

namespace roomwise::testing {

// Furniture as values, so that tests of homes need no archives: one or two models of each kind, of
// usual sizes.
inline std::vector<simulation::FurnitureModel> made_up_furniture() {
  std::vector<simulation::FurnitureModel> models;
  const auto add = [&](const char* kind, double width, double depth, double height, double top = 0,
                       double elevation = 0) {
    simulation::FurnitureModel model;
    model.id = std::string("made-up/") + kind + std::to_string(models.size());
    model.kind = kind;
    model.name = kind;
    model.size_m = {width, depth, height};
    model.top_m = top;
    model.elevation_m = elevation;
    model.creator = "nobody";
    model.license = "CC0";
    models.push_back(model);
  };
  add("bed", 1.4, 2.1, 0.95, 0.6);
  add("bed", 1.7, 2.17, 1.1, 0.55);
  add("lamp", 0.3, 0.3, 0.42);
  add("floor_lamp", 0.4, 0.5, 1.45);
  add("wardrobe", 0.95, 0.6, 2.0);
  add("wardrobe", 1.7, 0.6, 2.1);
  add("nightstand", 0.5, 0.42, 0.46, 0.46);
  add("chest_of_drawers", 0.9, 0.48, 0.8, 0.8);
  add("microwave", 0.42, 0.36, 0.26, 0.26);
  add("stove", 0.6, 0.6, 0.85, 0.85);
  add("fridge", 0.65, 0.65, 1.75, 1.75);
  add("sink", 0.6, 0.61, 1.2);
  add("kitchen_cabinet", 0.6, 0.61, 0.88, 0.88);
  add("kitchen_cabinet", 0.45, 0.61, 0.88, 0.88);
  add("kitchen_wall_cabinet", 0.6, 0.4, 0.7, 0, 1.45);
  add("hood", 0.6, 0.4, 0.4);
  add("toilet", 0.4, 0.65, 0.77);
  add("washbasin", 0.56, 0.46, 0.9);
  add("bathtub", 1.7, 0.72, 0.6);
  add("shower", 0.93, 0.95, 2.0);
  add("towel", 0.6, 0.1, 0.5, 0, 0.9);
  add("sofa", 1.95, 0.85, 0.85, 0.43);
  add("armchair", 0.8, 0.8, 0.9);
  add("coffee_table", 1.1, 0.6, 0.47, 0.47);
  add("tv_stand", 1.35, 0.47, 0.53, 0.53);
  add("tv", 0.8, 0.15, 0.5);
  add("dining_table", 1.4, 0.9, 0.75, 0.75);
  add("dining_table", 0.8, 0.8, 0.75, 0.75);
  add("chair", 0.45, 0.5, 0.9);
  add("desk", 1.25, 0.62, 0.74, 0.74);
  add("office_chair", 0.62, 0.62, 0.95);
  add("bookcase", 0.9, 0.35, 1.8);
  add("coat_rack", 1.1, 0.36, 1.3);
  add("plant", 0.5, 0.5, 0.95);
  add("rug", 1.8, 2.5, 0.03);
  add("rug", 0.7, 0.5, 0.01);
  add("radiator", 0.6, 0.12, 0.6, 0, 0.12);
  add("bin", 0.3, 0.3, 0.4);
  add("shoes", 0.25, 0.28, 0.12);
  add("laptop", 0.34, 0.25, 0.25);
  add("computer", 0.44, 0.36, 0.4);
  add("book", 0.28, 0.18, 0.03);
  add("cup", 0.1, 0.1, 0.1);
  add("bottle", 0.08, 0.08, 0.28);
  add("vase", 0.22, 0.22, 0.3);
  add("fruit", 0.28, 0.28, 0.15);
  add("toy", 0.3, 0.2, 0.3);
  add("clothes", 0.26, 0.4, 0.12);
  add("small_plant", 0.27, 0.27, 0.25);
  return models;
}

}  // namespace roomwise::testing
