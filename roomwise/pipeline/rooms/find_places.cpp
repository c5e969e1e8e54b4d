#include "roomwise/pipeline/rooms/find_places.h"

#include <algorithm>
#include <chrono>

namespace roomwise::pipeline {
namespace {

Expected<std::optional<TimedPlace>> find_place(const HomePlaces& places,
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
  const auto start = std::chrono::steady_clock::now();
  ROOMWISE_TRY(rooms::PlaceEvidence evidence, places.look(read, rooms));
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  return TimedPlace{std::move(evidence), elapsed.count()};
}

}  // namespace

Expected<TimedPlaces> find_places(const HomePlaces& places,
                                  std::span<const LabelledPicture> pictures,
                                  std::span<const PictureSpan> spans,
                                  std::span<const std::string> rooms, RunContext& run) {
  std::vector<Expected<std::optional<TimedPlace>>> found(spans.size());
  run.progress.begin("finding places", spans.size());
  const std::size_t block = 4 * run.pool.size();
  for (std::size_t begin = 0; begin < spans.size() && !run.progress.interrupted(); begin += block) {
    const std::size_t in_block = std::min(block, spans.size() - begin);
    run.pool.parallel_for(in_block, [&](std::size_t i) {
      found[begin + i] = find_place(places, pictures, spans[begin + i], rooms);
    });
    run.progress.advance(begin + in_block, "");
  }
  run.progress.end();
  if (run.progress.interrupted()) return fail("interrupted while finding places");
  TimedPlaces result;
  for (auto& one : found) {
    if (!one) return Unexpected(std::move(one).error());
    result.push_back(*std::move(one));
  }
  return result;
}

}  // namespace roomwise::pipeline
