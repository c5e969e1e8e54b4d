#include "roomwise/guide/surfaces.h"

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

constexpr double kAboveTop_m = 0.1;  // boxes end a hand's breadth early or late

double top_of_m(const KnownThing& thing) {
  return thing.position_gravity->z() + thing.size_m().z() / 2;
}

}  // namespace

Outline outline_of(const KnownThing& thing) {
  return {thing.position_gravity->head<2>(), thing.size_m().head<2>(), thing.yaw_rad};
}

bool stands_on(const KnownThing& thing, const KnownThing& surface) {
  if (&thing == &surface || !thing.position_gravity) return false;
  const objects::Kind* const kind = objects::find_kind(thing.name);
  if (kind != nullptr && kind->stands_on_floor) return false;
  const double middle_m = thing.position_gravity->z();
  const double bottom_m = middle_m - thing.size_m().z() / 2;
  return middle_m > surface.position_gravity->z() && bottom_m <= top_of_m(surface) + kAboveTop_m &&
         outline_of(surface).distance_m(thing.position_gravity->head<2>()) == 0;
}

const KnownThing* surface_under(const KnownThing& thing, std::span<const KnownThing> things) {
  const KnownThing* highest = nullptr;
  for (const KnownThing& one : things) {
    if (!one.position_gravity || one.is_own || !stands_on(thing, one)) continue;
    if (highest == nullptr || top_of_m(one) > top_of_m(*highest)) highest = &one;
  }
  return highest;
}

}  // namespace roomwise::guide
