#pragma once

#include <string_view>

namespace roomwise::simulation {

// The text of furniture.txt, compiled in by the build.
[[nodiscard]] std::string_view furniture_list();

}  // namespace roomwise::simulation
