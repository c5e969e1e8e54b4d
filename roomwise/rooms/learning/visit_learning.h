#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/rooms/recognition/localization_evidence.h"
#include "roomwise/rooms/recognition/room_classifier.h"
#include "roomwise/rooms/recognition/room_decision.h"

// Which pictures of a later visit rooms are known by from then on, beside those that they were
// learned from.
namespace roomwise::rooms {

struct VisitLearningOptions {
  // From this probability on, by the place alone, a camera stood deep in one room. Of a place that
  // no doorway is near it is 0.99.
  double min_inside = 0.95;
  std::size_t max_of_visit = 20;  // pictures of one room that one visit may bring
  std::size_t max_of_room = 60;   // that all visits together may have brought

  [[nodiscard]] Expected<void> validate() const;
};

// What a picture and its place say of the room, each without the other.
struct RoomAgreement {
  std::optional<std::size_t> by_picture;  // nothing: not sure, or none of the rooms
  std::optional<std::size_t> by_place;    // nothing: no certain place, or none deep in one room

  // Only such a picture may be learned.
  [[nodiscard]] bool is_agreed() const { return by_picture && by_picture == by_place; }
  [[nodiscard]] bool is_contradictory() const {
    return by_picture && by_place && by_picture != by_place;
  }
};

// The room that the place alone tells: where the pose is certain and its uncertainty lies in one
// room.
[[nodiscard]] std::optional<std::size_t> room_by_place(const LocalizationEvidence& place,
                                                       const VisitLearningOptions& options);
// The room that pictures alone tell: that which is named by the walk's pictures up to this one
// (RoomStream, without places), where this one looks more like it than like any other, and more
// like these rooms than like another home.
// `names`: of each room.
[[nodiscard]] std::optional<std::size_t> room_by_picture(const PictureEvidence& picture,
                                                         const RoomDecision& along_walk,
                                                         std::span<const std::string> names);

// Which of a visit's pictures to know the rooms by, in ascending order: of each room the least
// similar to what is remembered, then that which is least similar once the first is remembered, and
// so on, until max_of_visit are chosen or all that are left are about as similar as the pictures
// that the rooms were learned from are to each other. `remembered`: by room, how many of the
// visit's pictures the classifier remembers already, which count. Fails as RoomClassifier::with()
// does.
[[nodiscard]] Expected<std::vector<std::size_t>> choose_pictures(
    const RoomClassifier& classifier, std::span<const RoomPicture> agreed,
    const VisitLearningOptions& options, const std::map<std::string, std::size_t>& remembered = {});

}  // namespace roomwise::rooms
