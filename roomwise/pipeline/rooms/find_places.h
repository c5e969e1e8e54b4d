#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/pipeline/rooms/home_places.h"
#include "roomwise/pipeline/rooms/labelled_pictures.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// One picture of a list, or two that were taken shortly after one another.
struct PictureSpan {
  std::size_t first = 0;
  std::size_t second = 0;  // the same: one picture
};

// What a place told, and how long it took to measure the pictures and to find it (wall time).
struct TimedPlace {
  rooms::LocalizationEvidence evidence;
  double ms = 0;
};
// Of each span; nothing where a picture of it has no depth.
using TimedPlaces = std::vector<std::optional<TimedPlace>>;

// Looks for the places of all spans on the threads of the run. `rooms`: those that were learned.
// Fails where a picture cannot be read, and when the user interrupts.
[[nodiscard]] Expected<TimedPlaces> find_places(const HomePlaces& places,
                                                std::span<const LabelledPicture> pictures,
                                                std::span<const PictureSpan> spans,
                                                std::span<const std::string> rooms,
                                                RunContext& run);

}  // namespace roomwise::pipeline
