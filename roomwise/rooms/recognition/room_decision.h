#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/rooms/concepts/concepts.h"
#include "roomwise/rooms/concepts/room_objects.h"
#include "roomwise/rooms/recognition/room_classifier.h"
#include "roomwise/rooms/recognition/room_model.h"
#include "roomwise/rooms/recognition/two_frame_rule.h"

namespace roomwise::rooms {

enum class Verdict {
  kRoom,        // it is this room
  kEither,      // it is one of two; another picture would help
  kNotSure,     // it may be; another picture would help
  kNoneOfThem,  // nothing that was learned looks like this
};
[[nodiscard]] std::string_view to_string(Verdict verdict);  // "room", "either", ...

// In which room pictures were taken, or why that is not said.
struct RoomDecision {
  Verdict verdict = Verdict::kNotSure;
  // Every room with its probability, best first; they add up to 1. A room's probability holds if
  // the person is in one of the learned rooms at all, of which `familiarity` tells.
  std::vector<RoomScore> rooms;
  double familiarity = 0;  // log odds that the pictures show one of the learned rooms
  std::string why;         // for people: "the pictures look like the kitchen (0.97)"
  std::string object;      // the object that spoke most for the room; empty: none was needed

  // The room that is named; nothing where none is.
  [[nodiscard]] std::optional<std::string> room() const {
    return verdict == Verdict::kRoom ? std::optional(rooms.front().room) : std::nullopt;
  }
  // Whether it is said to be this room, or one of two of which this is one.
  [[nodiscard]] bool allows(std::string_view room) const;
};

// Pictures of one place are alike and say nearly the same: n of them count as n / (1 + (n - 1) / 2)
// that were independent (Kish's design effect, with a correlation of a half).
[[nodiscard]] double effective_sample_size(double pictures);

// Several pictures of one place as one that says as much as they do. At least one picture.
[[nodiscard]] PictureEvidence combine(std::span<const PictureEvidence> pictures);

// How probable it is in each room (in the order of `rooms`) that the network says what it says of
// objects, up to a factor: the mean over all rooms is 1. An object speaks for the rooms whose
// pictures show it, by how often they do; one that no picture of the home shows for those of the
// type that alone has it; both as far as the network's word is trusted.
[[nodiscard]] Eigen::VectorXd likelihood_of_objects(std::span<const objects::ObjectScore> objects,
                                                    const Concepts& concepts,
                                                    std::span<const Room> rooms,
                                                    const RoomObjects& learned = {});

// The verdict on combined pictures: none of the rooms below the model's reject_log_odds; the best
// room where the probability that it is right reaches min_probability; one of the best two where
// theirs together does; else not sure. `names`: of each room.
[[nodiscard]] RoomDecision decide(const PictureEvidence& evidence,
                                  std::span<const std::string> names, const RoomModel& model);
// The same with what objects say (likelihood_of_objects, with its objects and the types of rooms).
// They do not make it more familiar.
[[nodiscard]] RoomDecision decide_with_objects(const PictureEvidence& evidence,
                                               std::span<const objects::ObjectScore> objects,
                                               const Concepts& concepts,
                                               std::span<const Room> rooms, const RoomModel& model,
                                               const RoomObjects& learned = {});

}  // namespace roomwise::rooms
