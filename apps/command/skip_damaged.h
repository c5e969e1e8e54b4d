#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

namespace roomwise::app {

inline constexpr const char* kSkipDamaged = "--skip-damaged";

// What an error is told with of a frame or picture that it would leave out.
inline constexpr const char* kNamingSkipDamaged = "; give --skip-damaged to go on without it";

// Of what it left out.
inline std::string damage_text(const std::vector<std::string>& damage, std::string_view of_what) {
  if (damage.empty()) return "";
  std::string text = fmt::format("left out    {} {}:\n", damage.size(), of_what);
  for (const std::string& one : damage) text += fmt::format("  {}\n", one);
  return text;
}

}  // namespace roomwise::app
