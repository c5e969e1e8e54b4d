#include "roomwise/pipeline/mapping/camera_check.h"

#include <utility>
#include <vector>

#include "roomwise/base/spread.h"
#include "roomwise/pipeline/in_blocks.h"

namespace roomwise::pipeline {

Expected<std::optional<motion::FocalLengthFit>> check_focal_length(
    mapping::Mapper& mapper, mapping::KeyframeId first, const geometry::PinholeCamera& camera,
    std::uint64_t seed, RunContext& run) {
  constexpr std::size_t kMaxBeginnings = 40;
  const std::size_t count = mapper.keyframes().size() - first;
  std::vector<std::pair<mapping::KeyframeId, mapping::KeyframeId>> pairs;
  for (const std::size_t from : spread_evenly(count, kMaxBeginnings)) {
    for (const std::size_t apart : {1U, 2U, 4U}) {
      if (from + apart < count) pairs.emplace_back(first + from, first + from + apart);
    }
  }
  const motion::MotionOptions options;
  std::vector<motion::MatchedViews> views;
  struct Both {
    mapping::SharedMeasurements reference, current;
  };
  const auto read = [&](std::size_t i) -> Expected<Both> {
    ROOMWISE_TRY(mapping::SharedMeasurements reference, mapper.measurements(pairs[i].first));
    ROOMWISE_TRY(mapping::SharedMeasurements current, mapper.measurements(pairs[i].second));
    // Found here, where no other thread asks for them.
    static_cast<void>(reference->features());
    static_cast<void>(current->features());
    return Both{std::move(reference), std::move(current)};
  };
  const auto match = [&](std::size_t i,
                         const Both& both) -> Expected<std::optional<motion::MatchedViews>> {
    const auto timing = run.clock.measure("camera check");
    motion::MatchedViews seen{motion::match_points(both.reference->features(),
                                                   both.current->features(), options.matching),
                              {}};
    const motion::MotionOutcome motion = motion::estimate_motion(
        seen.observations, camera, options, RandomStream(seed, {pairs[i].first, pairs[i].second}));
    if (!motion.found()) return std::optional<motion::MatchedViews>();
    seen.reference_from_current = motion.pose.reference_from_current;
    return std::optional(std::move(seen));
  };
  const auto take = [&](std::size_t, std::optional<motion::MatchedViews> seen) -> Expected<void> {
    if (seen) views.push_back(*std::move(seen));
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(in_blocks(pairs.size(), "checking the camera", run, read, match, take));
  const auto timing = run.clock.measure("camera check");
  return motion::fit_focal_length(std::move(views), camera, options);
}

}  // namespace roomwise::pipeline
