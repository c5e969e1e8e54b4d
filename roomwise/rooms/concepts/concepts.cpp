#include "roomwise/rooms/concepts/concepts.h"

namespace roomwise::rooms {

Concepts Concepts::standard() {
  Concepts concepts;
  concepts.vocabulary = objects::ObjectVocabulary::standard();
  concepts.objects_of_room_type = {
      {"bedroom", {"bed", "lamp", "wardrobe"}},
      {"kitchen", {"fridge", "microwave", "stove"}},
      {"toilet", {"toilet seat"}},
  };
  return concepts;
}

std::optional<std::string> Concepts::represented_room_type(std::string_view object) const {
  std::optional<std::string> represented;
  for (const auto& [type, objects] : objects_of_room_type) {
    if (!objects.contains(std::string(object))) continue;
    if (represented) return std::nullopt;
    represented = type;
  }
  return represented;
}

}  // namespace roomwise::rooms
