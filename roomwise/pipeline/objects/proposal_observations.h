#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "roomwise/objects/proposals/proposal_classifier.h"

namespace roomwise::pipeline {

// What stands apart in the depth of pictures (objects::find_proposals), and what the pictures that
// show it best say of it. Pictures are known by their ObservedKeyframe::keyframe_id.
class ProposalObservations {
 public:
  // What a picture shows of a proposal.
  struct ViewObservation {
    objects::ClassScores said;
    objects::DetectionSurface surface;
  };

  // `pictures` must outlive it.
  ProposalObservations(const std::vector<objects::ObservedKeyframe>& pictures,
                       const objects::GroundPlane& level);

  // Whether a picture is one of those that show a proposal best.
  [[nodiscard]] bool is_shown_by(std::uint64_t picture) const {
    return views_of_picture_.contains(picture);
  }
  // What a picture shows of each of its proposals; to be handed to keep(). Only of pictures that
  // is_shown_by() names. May be called from several threads at once. Fails where the classifier
  // does.
  [[nodiscard]] Expected<std::vector<ViewObservation>> look(
      std::uint64_t picture, const image::ColorImage& color, const image::DepthImage& depth,
      const objects::ProposalClassifier& proposal_classifier) const;
  void keep(std::uint64_t picture, std::vector<ViewObservation> observations);

  // Of each picture that shows a proposal with a name, by all that was kept; the best first.
  [[nodiscard]] std::map<std::uint64_t, std::vector<objects::Detection>> detections() const;

 private:
  // A view of a proposal, by its indices.
  struct ViewPlace {
    std::size_t proposal = 0, view = 0;
  };

  const std::vector<objects::ObservedKeyframe>* pictures_;
  std::vector<objects::ScoredProposal> looked_;
  std::vector<std::vector<objects::DetectionSurface>> surfaces_;  // by proposal and view
  std::map<std::uint64_t, std::vector<ViewPlace>> views_of_picture_;
};

}  // namespace roomwise::pipeline
