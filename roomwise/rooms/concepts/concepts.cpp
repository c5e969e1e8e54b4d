#include "roomwise/rooms/concepts/concepts.h"

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::rooms {

Concepts Concepts::standard() {
  Concepts concepts;
  concepts.vocabulary = objects::ObjectVocabulary::standard();
  for (const objects::Kind& kind : objects::standard_kinds()) {
    if (kind.room_type.empty()) continue;
    concepts.objects_of_room_type[kind.room_type].insert(kind.name);
  }
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
