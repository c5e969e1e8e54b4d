#include "roomwise/pipeline/objects/proposal_observations.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

namespace roomwise::pipeline {

ProposalObservations::ProposalObservations(const std::vector<objects::ObservedKeyframe>& pictures,
                                           const objects::GroundPlane& level)
    : pictures_(&pictures) {
  for (auto& proposal : objects::find_proposals(pictures, level)) {
    objects::ScoredProposal looked{std::move(proposal), {}, {}};
    looked.views = objects::best_views(looked.proposal, pictures);
    looked.said.resize(looked.views.size());
    surfaces_.emplace_back(looked.views.size());
    for (std::size_t view = 0; view < looked.views.size(); ++view) {
      const objects::ObservedKeyframe& picture = pictures[looked.views[view].keyframe];
      views_of_picture_[picture.keyframe_id].push_back({looked_.size(), view});
    }
    looked_.push_back(std::move(looked));
  }
}

Expected<std::vector<ProposalObservations::ViewObservation>> ProposalObservations::look(
    std::uint64_t picture, const image::ColorImage& color, const image::DepthImage& depth,
    const objects::ProposalClassifier& proposal_classifier) const {
  std::vector<ViewObservation> observations;
  for (const ViewPlace& place : views_of_picture_.at(picture)) {
    const objects::ScoredProposal& looked = looked_[place.proposal];
    const objects::ProposalView& view = looked.views[place.view];
    const objects::ObservedKeyframe& from = (*pictures_)[view.keyframe];
    const geometry::OrientedBox& box = looked.proposal.box_world;
    ViewObservation& observation = observations.emplace_back();
    ROOMWISE_TRY(observation.said, proposal_classifier.look(color, view.box, looked.proposal));
    observation.surface = objects::surface_within(
        depth, from.camera, view.box,
        {from.world_from_camera.inverse() * box.world_from_box, box.size_m});
  }
  return observations;
}

void ProposalObservations::keep(std::uint64_t picture, std::vector<ViewObservation> observations) {
  const std::vector<ViewPlace>& places = views_of_picture_.at(picture);
  for (std::size_t i = 0; i < places.size(); ++i) {
    looked_[places[i].proposal].said[places[i].view] = std::move(observations[i].said);
    surfaces_[places[i].proposal][places[i].view] = std::move(observations[i].surface);
  }
}

std::map<std::uint64_t, std::vector<objects::Detection>> ProposalObservations::detections() const {
  static const std::map<std::string, std::string> labels = objects::labels_of_proposals();
  std::map<std::uint64_t, std::vector<objects::Detection>> detections;
  for (const objects::ProposalClass& named : objects::classify_proposals(looked_)) {
    const objects::ScoredProposal& looked = looked_[named.proposal];
    for (std::size_t view = 0; view < looked.views.size(); ++view) {
      const std::uint64_t picture = (*pictures_)[looked.views[view].keyframe].keyframe_id;
      detections[picture].push_back({labels.at(named.word), static_cast<float>(named.score),
                                     looked.views[view].box, surfaces_[named.proposal][view],
                                     objects::DetectionSource::kProposal});
    }
  }
  for (auto& [picture, of_picture] : detections) {
    std::ranges::stable_sort(of_picture, std::greater{}, &objects::Detection::score);
  }
  return detections;
}

}  // namespace roomwise::pipeline
