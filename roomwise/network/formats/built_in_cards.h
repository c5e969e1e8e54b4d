#pragma once

#include <span>
#include <string_view>

namespace roomwise::network {

struct BuiltInCard {
  std::string_view network;  // the weights file's name without its ending
  std::string_view json;
};

// The cards in models/, compiled in by the build.
[[nodiscard]] std::span<const BuiltInCard> built_in_cards();
// models/catalogue.json, likewise.
[[nodiscard]] std::string_view built_in_catalogue();

}  // namespace roomwise::network
