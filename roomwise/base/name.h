#pragma once

#include <string_view>

namespace roomwise {

// Whether it is one line of UTF-8 of which everything is seen: no control characters, no separators
// of lines, and none of Unicode's characters without a shape, by which a text can look like another
// (some turn the direction of writing), but for joiners within it.
[[nodiscard]] bool is_legible(std::string_view text);

// Whether people can be shown and told it as a name: legible, with a letter or a digit.
[[nodiscard]] bool is_name(std::string_view text);

}  // namespace roomwise
