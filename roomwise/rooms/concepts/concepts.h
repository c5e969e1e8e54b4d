#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::rooms {

// What a home is made of: objects (with the network's labels for them), room types, and has-a
// relations. A room type is defined by the objects it contains.
struct Concepts {
  objects::ObjectVocabulary vocabulary;
  std::map<std::string, std::set<std::string>> objects_of_room_type;  // has-a

  // The paper's home: bedroom (bed, lamp, wardrobe), kitchen (microwave, stove, fridge), toilet
  // (toilet seat).
  [[nodiscard]] static Concepts standard();

  // The one room type that has the object; nothing where none or several have it (the object then
  // represents no room).
  [[nodiscard]] std::optional<std::string> represented_room_type(std::string_view object) const;
};

}  // namespace roomwise::rooms
