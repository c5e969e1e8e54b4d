#include "roomwise/guide/words/prompt.h"

#include <array>

namespace roomwise::guide {
namespace {

// The names in the order of the enumeration.
template <typename Enum, std::size_t N>
std::string_view name_of(Enum value, const std::array<std::string_view, N>& names) {
  const auto place = static_cast<std::size_t>(value);
  return place < N ? names[place] : "unknown";
}

}  // namespace

std::string_view to_string(Priority priority) {
  return name_of<Priority, 4>(priority, {"hazard", "answer", "notice", "callout"});
}

std::string_view to_string(Confidence confidence) {
  return name_of<Confidence, 3>(confidence, {"sure", "probable", "unsure"});
}

std::string_view to_string(Sound sound) {
  return name_of<Sound, 6>(sound, {"none", "answer", "unsure", "lost", "back", "alert"});
}

}  // namespace roomwise::guide
