#include "roomwise/pipeline/rooms/find_places.h"

#include "roomwise/base/stopwatch.h"
#include "roomwise/pipeline/in_blocks.h"

namespace roomwise::pipeline {
namespace {

Expected<std::optional<TimedPlace>> localize(const HomePlaces& places,
                                             std::span<const LabelledPicture> pictures,
                                             const PictureSpan& span,
                                             std::span<const std::string> rooms) {
  const LabelledPicture& first = pictures[span.first];
  const LabelledPicture& second = pictures[span.second];
  if (!first.read_to_locate || !second.read_to_locate) return std::optional<TimedPlace>();
  std::vector<PictureToLocate> read;
  if (span.first != span.second) {
    ROOMWISE_TRY(read.emplace_back(), first.read_to_locate());
  }
  ROOMWISE_TRY(read.emplace_back(), second.read_to_locate());
  const Stopwatch watch;
  ROOMWISE_TRY(rooms::LocalizationEvidence evidence, places.look(read, rooms));
  return TimedPlace{std::move(evidence), watch.ms()};
}

}  // namespace

Expected<TimedPlaces> find_places(const HomePlaces& places,
                                  std::span<const LabelledPicture> pictures,
                                  std::span<const PictureSpan> spans,
                                  std::span<const std::string> rooms, RunContext& run) {
  TimedPlaces found;
  const auto span = [&](std::size_t i) -> Expected<PictureSpan> { return spans[i]; };
  const auto find = [&](std::size_t, const PictureSpan& of_pictures) {
    return localize(places, pictures, of_pictures, rooms);
  };
  const auto take = [&](std::size_t, std::optional<TimedPlace> place) -> Expected<void> {
    found.push_back(std::move(place));
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(in_blocks(spans.size(), "finding places", run, span, find, take));
  return found;
}

}  // namespace roomwise::pipeline
