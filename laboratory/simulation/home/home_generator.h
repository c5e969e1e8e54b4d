#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

struct HomeOptions {
  std::uint64_t seed = 0;
  // The kinds of its rooms; a hall is added where none is named. Empty: 3 to 8, by the seed.
  std::vector<RoomKind> rooms;
  int storeys = 1;  // 1 or 2: the rooms above are chosen by the seed
  // Another home of the same plan, of one storey: what stands, hangs and shines in it, and what
  // floors, walls and ceilings are covered with, each by the seed where absent; and whether left
  // and right are exchanged.
  std::optional<std::uint64_t> furniture_seed = std::nullopt, finish_seed = std::nullopt;
  bool mirrored = false;

  [[nodiscard]] Expected<void> validate() const;
};

// A furnished home by day. The same seed gives the same home. A kind of furniture that has no model
// is left out.
[[nodiscard]] Expected<HomeModel> generate_home(const HomeOptions& options,
                                                std::span<const FurnitureModel> models);
[[nodiscard]] Expected<HomeModel> generate_home(const HomeOptions& options,
                                                const FurnitureCatalogue& catalogue);

// The kinds that the reference flat has, each exactly once.
[[nodiscard]] std::span<const std::string_view> reference_kinds();

// The home of the paper: bedroom, kitchen, toilet and hall, with a bed, a lamp, a wardrobe, a
// microwave, a stove, a fridge and a toilet, each once, and other furniture. Always the same. Fails
// where one of the seven has no model.
[[nodiscard]] Expected<HomeModel> reference_flat(std::span<const FurnitureModel> models);
[[nodiscard]] Expected<HomeModel> reference_flat(const FurnitureCatalogue& catalogue);

}  // namespace roomwise::simulation
