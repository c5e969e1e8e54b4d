#pragma once

#include <optional>
#include <span>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/rooms/recognition/localization_evidence.h"

namespace roomwise::pipeline {

// Says what the place of pictures on a home's map tells of the room: finds where they were taken
// and which room's floor that is.
class HomePlaces {
 public:
  // Makes the localiser ready and finds the floor (see find_home_floor). Fails where the home has
  // no map, and when the user interrupts. Where no rooms were named, or the map shows no floor,
  // places tell whether pictures are of this home, and no rooms.
  [[nodiscard]] static Expected<HomePlaces> create(const home::Home& home,
                                                   const mapping::LocalizerOptions& options,
                                                   RunContext& run);

  // Of one picture, or of two that were taken shortly after one another (of both together).
  // `rooms`: those that were learned. Fails where an image is not of its camera's size.
  [[nodiscard]] Expected<rooms::LocalizationEvidence> look(
      std::span<const PictureToLocate> pictures, std::span<const std::string> rooms) const;
  // The same from what localizer() answered.
  [[nodiscard]] rooms::LocalizationEvidence evidence(const mapping::Localization& answer,
                                                     bool has_depth,
                                                     std::span<const std::string> rooms) const {
    return rooms::localization_evidence(answer, has_depth, frame_, layout_, rooms);
  }

  [[nodiscard]] const HomeLocalizer& localizer() const { return localizer_; }
  [[nodiscard]] bool tells_rooms() const { return layout_.has_value(); }

 private:
  HomePlaces(HomeLocalizer localizer, const fusion::GravityAlignedFrame& frame)
      : localizer_(std::move(localizer)), frame_(frame) {}

  HomeLocalizer localizer_;
  fusion::GravityAlignedFrame frame_;
  std::optional<rooms::RoomLayout> layout_;
};

}  // namespace roomwise::pipeline
