#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/rooms/concepts/concepts.h"

namespace roomwise::rooms {

// A room of the home and how probable it is.
struct RoomScore {
  std::string room;
  double score = 0;  // probability, [0, 1]

  friend bool operator==(const RoomScore&, const RoomScore&) = default;
};

// How an answer was reached, for people and for tests.
enum class Reason {
  kSingleFrame,           // only one picture was given
  kFramesAgree,           // both pictures give the same room
  kRepresentativeObject,  // they differ; an object of the second picture stands in one room only
  kHigherScore,           // they differ, no such object; the surer picture decides
};
[[nodiscard]] std::string_view to_string(
    Reason reason);  // "frames agree", "representative object", ...

struct RoomAnswer {
  std::string room;
  double score = 0;
  Reason reason = Reason::kSingleFrame;
  std::string object;  // the representative object, if it decided
};

// A room of the home: what people call it and of which type it is.
struct Room {
  std::string name;
  std::string type;

  friend bool operator==(const Room&, const Room&) = default;
};

// The paper's rule for two pictures. `first` and `second` are the best room of each picture. Where
// they differ, `objects_of_second()` is asked for the objects of the second picture (top three,
// best first): the first of them that represents exactly one room type, of which the home has
// exactly one room, decides; else the higher score, the second picture's where both are equal. The
// objects are asked for only when they are needed, since a network must look for them.
[[nodiscard]] RoomAnswer decide(
    const RoomScore& first, const RoomScore& second,
    const std::function<std::vector<objects::ObjectScore>()>& objects_of_second,
    const Concepts& concepts, std::span<const Room> rooms);

}  // namespace roomwise::rooms
