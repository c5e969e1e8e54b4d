#include "roomwise/pipeline/objects/proposal_detection.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "roomwise/pipeline/objects/proposal_observations.h"
#include "roomwise/pipeline/objects/stored_detections.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {
namespace {

// Fails as for_each_keyframe() does.
Expected<void> look_at_proposals(ProposalObservations& proposals, const home::Home& home,
                                 const std::vector<home::Keyframe>& keyframes,
                                 const objects::ProposalClassifier& proposal_classifier,
                                 RunContext& run) {
  std::vector<home::Keyframe> shown;
  std::ranges::copy_if(keyframes, std::back_inserter(shown),
                       [&](const home::Keyframe& one) { return proposals.is_shown_by(one.id); });
  if (shown.empty()) return {};
  using Seen = Expected<std::vector<ProposalObservations::ViewObservation>>;
  return for_each_keyframe(
      home, shown, "looking closer", run,
      [&](const home::Keyframe& keyframe, const DecodedImages& images) -> Seen {
        const auto timing = run.clock.measure("region proposals");
        return proposals.look(keyframe.id, images.color, images.depth, proposal_classifier);
      },
      [&](const home::Keyframe& keyframe, Seen seen) -> Expected<void> {
        if (!seen) return Unexpected(std::move(seen).error());
        proposals.keep(keyframe.id, *std::move(seen));
        return {};
      });
}

// All region proposals are one finder, whatever networks take part: each time they are made they
// take the place of the last ones, so that nothing of other networks or other poses stays.
home::RegionFinderRecord finder_record() {
  home::RegionFinderRecord record{.name = "region proposals", .fingerprint = {}, .labels = {}};
  for (const auto& [word, label] : objects::labels_of_proposals()) record.labels.push_back(label);
  record.fingerprint =
      fmt::format("{}2: {}", objects::kProposalMethod, fmt::join(record.labels, ", "));
  return record;
}

}  // namespace

Expected<void> redetect_on_proposals(home::Home& home,
                                     const objects::ProposalClassifier& proposal_classifier,
                                     RunContext& run) {
  ROOMWISE_TRY(const auto components, observed_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::map<home::KeyframeId, objects::KeyframeDetections> closer;
  for (const auto& [component, looked] : components) {
    ROOMWISE_RETURN_IF_ERROR(run.progress.check("looking closer"));
    ProposalObservations proposals = [&] {
      const auto timing = run.clock.measure("what stands apart");
      return ProposalObservations(looked, objects::fit_ground_plane(looked));
    }();
    ROOMWISE_RETURN_IF_ERROR(
        look_at_proposals(proposals, home, keyframes, proposal_classifier, run));
    const auto lost = run.lost ? run.lost->all() : std::map<home::KeyframeId, std::string>();
    auto detections = proposals.detections();
    for (const objects::ObservedKeyframe& keyframe : looked) {
      // What was seen in a picture while it could be read stays.
      if (lost.contains(keyframe.keyframe_id)) continue;
      closer[keyframe.keyframe_id] = {keyframe.coarse_depth,
                                      std::move(detections[keyframe.keyframe_id])};
    }
  }
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const home::FinderId finder, home.add_region_finder(finder_record()));
    for (const auto& [id, look] : closer) {
      ROOMWISE_RETURN_IF_ERROR(home.put_detections(id, finder, look));
    }
    return {};
  });
}

}  // namespace roomwise::pipeline
