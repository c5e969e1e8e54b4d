#pragma once

#include <algorithm>
#include <span>
#include <string_view>

namespace roomwise::network {

struct BuiltInText {
  std::string_view name;
  std::string_view text;
};

// The cards in models/, compiled in by the build, each by its weights file's name without ending.
[[nodiscard]] std::span<const BuiltInText> built_in_cards();
// Null: none of that name.
[[nodiscard]] inline const BuiltInText* find_built_in_card(std::string_view name) {
  const auto cards = built_in_cards();
  const auto found = std::ranges::find(cards, name, &BuiltInText::name);
  return found == cards.end() ? nullptr : &*found;
}
// Files of labels, a label a line, likewise, by their names.
[[nodiscard]] std::span<const BuiltInText> built_in_labels();
// models/catalogue.json, likewise.
[[nodiscard]] std::string_view built_in_catalogue();

}  // namespace roomwise::network
