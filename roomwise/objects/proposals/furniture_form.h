#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace roomwise::objects {

// What furniture is by its form alone: people sit, eat and work at heights that are alike
// everywhere.
enum class FurnitureForm {
  kTable,  // little but a level surface at 0.62 to 0.80 m, or a lower one without sides
  kChair,  // a seat with a back along one side, no longer than an armchair
  kSofa,   // a seat with a back along one of its long sides
};

// The form of what stands apart; absent where it has none of these. `cells`: the middles of the
// cells of a grid that its surface crosses, each once, not none, in a frame whose z is the height
// above the floor, m; `cell_m`: their side.
[[nodiscard]] std::optional<FurnitureForm> form_of(std::span<const Eigen::Vector3f> cells,
                                                   double cell_m);

}  // namespace roomwise::objects
