#include "roomwise/pipeline/home_places.h"

#include <stdexcept>

#include "roomwise/pipeline/home_layout.h"

namespace roomwise::pipeline {

Expected<HomePlaces> HomePlaces::create(const home::Home& home,
                                        const mapping::LocalizerOptions& options, RunContext& run) {
  ROOMWISE_TRY(HomeLocalizer localizer, HomeLocalizer::create(home, options, run));
  ROOMWISE_TRY(const LevelMap map, build_level_map(home, fusion::FieldOptions{}.voxel_size_m, run));
  HomePlaces places(std::move(localizer), map.frame);
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (map.frame.has_floor && !rooms.empty()) {
    ROOMWISE_TRY(const fusion::FloorGrid floor, floor_grid_of(map, {}, run));
    // Where nobody walked on free floor in a named room there is no layout.
    if (auto layout = lay_out_rooms(home, map.frame, floor)) places.layout_ = *std::move(layout);
  }
  return places;
}

Expected<rooms::PlaceEvidence> HomePlaces::look(std::span<const PictureToLocate> pictures,
                                                std::span<const std::string> rooms) const {
  if (pictures.empty() || pictures.size() > 2) {
    throw std::invalid_argument("HomePlaces: one picture or two have a place");
  }
  const PictureToLocate& last = pictures.back();
  ROOMWISE_TRY(const motion::FrameMeasurements measured, localizer_.measure(last));
  mapping::Localization answer;
  if (pictures.size() == 1) {
    answer = localizer_.localizer().locate({measured, last.camera});
  } else {
    ROOMWISE_TRY(const motion::FrameMeasurements first, localizer_.measure(pictures.front()));
    answer =
        localizer_.localizer().locate({first, pictures.front().camera}, {measured, last.camera});
  }
  return evidence(answer, last.depth.has_value(), rooms);
}

}  // namespace roomwise::pipeline
