#pragma once

#include <span>
#include <string_view>

namespace roomwise::network {

struct BuiltInText {
  std::string_view name;
  std::string_view text;
};

// The cards in models/, compiled in by the build, each by its weights file's name without ending.
[[nodiscard]] std::span<const BuiltInText> built_in_cards();
// Files of labels, a label a line, likewise, by their names.
[[nodiscard]] std::span<const BuiltInText> built_in_labels();
// models/catalogue.json, likewise.
[[nodiscard]] std::string_view built_in_catalogue();

}  // namespace roomwise::network
