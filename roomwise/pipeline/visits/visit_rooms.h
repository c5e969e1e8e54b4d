#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/rooms/home_places.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/rooms/learning/visit_learning.h"

namespace roomwise::pipeline {

// A picture of a visit, and what it and its place tell of the room, each without the other.
struct SeenPicture {
  home::VisitPicture picture;  // without a room
  rooms::PictureEvidence evidence;
  rooms::LocalizationEvidence place;
};

// What a picture of a visit tells of its room, with the pictures before it.
struct RoomObservation {
  std::string picture_digest;
  rooms::RoomAgreement agreement;
  // Where picture and place agree: as the home is to keep it.
  std::optional<home::VisitPicture> picture;
};

// By which pictures of a visit the rooms are known from then on.
struct RoomUpdate {
  struct OfRoom {
    std::string room;
    std::size_t agreed = 0;    // pictures of the visit that show it, by picture and by place
    std::size_t learned = 0;   // of these, those that are to be remembered
    std::size_t outdated = 0;  // of earlier visits, that are not remembered any more
  };
  std::vector<OfRoom> rooms = {};  // those that were learned, by name
  std::size_t contradictory = 0;   // pictures: the place is deep in another room
  std::size_t unsure = 0;          // pictures: the picture, the place or both tell no room
  bool was_learned = false;        // what this walk brings is remembered already: nothing changes
  std::string why_not = {};        // no rooms could be refreshed; empty: they could
  // As HomeChanges takes them; absent where nothing changes.
  std::optional<std::vector<home::VisitPicture>> pictures = std::nullopt;
};

// Of all pictures of a visit, in the order of time. `stream` has seen nothing yet; `names`: of the
// rooms.
[[nodiscard]] std::vector<RoomObservation> observations_along_walk(
    rooms::RoomStream stream, std::span<const std::string> names, std::span<const SeenPicture> walk,
    const rooms::VisitLearningOptions& options);

// `looks`: of all pictures of a visit, in the order of time. `classifier`: as RoomRecognizer has
// it; `before`: Home::visit_pictures(). What the home keeps of earlier visits stays, but for the
// oldest pictures of rooms that would have more than options.max_of_room. Pictures of this walk
// that are among them count as those of the visit. Fails as rooms::choose_pictures() does.
[[nodiscard]] Expected<RoomUpdate> refresh_rooms(const rooms::RoomClassifier& classifier,
                                                 std::span<const RoomObservation> looks,
                                                 const std::vector<home::VisitPicture>& before,
                                                 const rooms::VisitLearningOptions& options);

// Looks at the pictures of a later visit and says by which of them the home's rooms are to be known
// from then on (rooms/visit_learning.h). Reads only; look() may be called by several threads.
class VisitRooms {
 public:
  // `networks` as RoomRecognizer::create() takes them. Fails where it fails, and where the home has
  // no map.
  [[nodiscard]] static Expected<VisitRooms> create(const home::Home& home, const Networks& networks,
                                                   const rooms::VisitLearningOptions& options,
                                                   const mapping::LocalizerOptions& localizer,
                                                   RunContext& run);

  [[nodiscard]] const HomeLocalizer& localizer() const { return places_.localizer(); }

  // `found`: where the frame, which has its encoded colour image, was taken.
  [[nodiscard]] Expected<SeenPicture> look(const image::RgbdFrame& frame,
                                           const mapping::Localization& found) const;
  // refresh_rooms() of the home with all pictures of the visit, in the order of time; why not,
  // where the map does not show where the rooms lie.
  [[nodiscard]] Expected<RoomUpdate> update(const home::Home& home,
                                            std::span<const SeenPicture> walk) const;

 private:
  VisitRooms(HomePlaces places, RoomRecognizer recognizer,
             const rooms::VisitLearningOptions& options)
      : places_(std::move(places)), recognizer_(std::move(recognizer)), options_(options) {}

  HomePlaces places_;
  RoomRecognizer recognizer_;
  rooms::VisitLearningOptions options_;
};

// Why the rooms of a home cannot be refreshed, whatever a visit shows; empty where they can.
[[nodiscard]] Expected<std::string> why_rooms_cannot_be_refreshed(const home::Home& home);

}  // namespace roomwise::pipeline
