#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "roomwise/rooms/concepts/concepts.h"

namespace roomwise::rooms {

// The classes of what stands in a room, each with the probability that one does.
using RoomContents = std::map<std::string, double>;

// A room of a known type and what stands in it.
struct TypedContents {
  std::string type;
  RoomContents contents;
};

struct TypePosterior {
  std::string type;  // kOtherType: none of the types that are known
  double probability = 0;
  std::vector<std::string> because;  // classes that speak for it, the best first
};
inline constexpr const char* kOtherType = "";

// Of which type a room is by what stands in it, and by what does not: naive Bayes over the classes
// that any type has. That a room has one is more probable where its type has it by the concepts;
// `examples`, the home's own rooms of known types, move that. A type that nothing speaks for has
// probability 0. All types, the most probable first; they add up to 1.
[[nodiscard]] std::vector<TypePosterior> classify_room_type(
    const RoomContents& contents, const Concepts& concepts,
    std::span<const TypedContents> examples = {});

}  // namespace roomwise::rooms
