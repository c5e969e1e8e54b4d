#include "roomwise/pipeline/rooms/home_places.h"

#include <stdexcept>

#include "roomwise/pipeline/rooms/home_layout.h"

namespace roomwise::pipeline {

Expected<HomePlaces> HomePlaces::create(const home::Home& home,
                                        const mapping::LocalizerOptions& options, RunContext& run) {
  ROOMWISE_TRY(HomeLocalizer localizer, HomeLocalizer::create(home, options, run));
  ROOMWISE_TRY(const HomeFloor floor, find_home_floor(home, run));
  HomePlaces places(std::move(localizer), floor.frame);
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (floor.grid && !rooms.empty()) {
    ROOMWISE_TRY(places.layout_, find_room_layout(home, floor.frame, *floor.grid));
  }
  return places;
}

Expected<rooms::LocalizationEvidence> HomePlaces::look(std::span<const PictureToLocate> pictures,
                                                       std::span<const std::string> rooms) const {
  if (pictures.empty() || pictures.size() > 2) {
    throw std::invalid_argument("HomePlaces: one picture or two have a place");
  }
  const PictureToLocate& last = pictures.back();
  ROOMWISE_TRY(const motion::FrameMeasurements measured, localizer_.measure(last));
  const auto tell = [&](const auto& answer) {
    return rooms::localization_evidence(answer, last.depth.has_value(), frame_, layout_, rooms);
  };
  const mapping::Localizer& localizer = localizer_.localizer();
  if (pictures.size() == 1) return tell(localizer.locate({measured, last.camera}));
  ROOMWISE_TRY(const motion::FrameMeasurements first, localizer_.measure(pictures.front()));
  return tell(localizer.locate({first, pictures.front().camera}, {measured, last.camera}));
}

}  // namespace roomwise::pipeline
