#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/network/vision/classifier.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/objects/kinds/kinds.h"
#include "roomwise/objects/proposals/proposals.h"

namespace roomwise::objects {

// How probable a picture makes it that a thing is of each kind, by name, [0, 1]; kinds that nothing
// speaks for may be missing.
using ClassScores = std::map<std::string, double>;

// Says of which kind a thing is that a box of a picture shows. look() may be called from several
// threads at once.
class ProposalClassifier {
 public:
  virtual ~ProposalClassifier() = default;

  [[nodiscard]] virtual Expected<ClassScores> look(const image::ColorImage& picture,
                                                   const network::PixelBox& box,
                                                   const Proposal& thing) const = 0;
};

// Shows the square about the box to a detector and to a classifier, large and in the middle, as
// they want it: what is small or far in a whole picture, or fills it, is named so. What they say is
// weighed by the thing's size (KindsOfLabels); of a kind the surer of both is believed.
[[nodiscard]] std::unique_ptr<ProposalClassifier> network_proposal_classifier(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier);

// What a network's labels say of a thing as large as that. The probability of a label is given to
// the kinds that it means by Bayes' rule: in proportion to how dense such sizes are among them, and
// among things of no kind, whose sides are spread evenly from 2 cm to 4 m.
class KindsOfLabels {
 public:
  // Of each label the kinds that it means, by index of kinds. Kinds must outlive it.
  KindsOfLabels(std::span<const std::string> labels, std::span<const Kind> kinds);
  // `said`: the probability of each label.
  [[nodiscard]] ClassScores scores(std::span<const float> said, const Proposal& thing) const;

 private:
  std::vector<std::vector<const Kind*>> of_label_;
};

// What a detector says of a box: of each label the best of the detections that overlap it by half.
[[nodiscard]] std::vector<float> labels_of_box(std::span<const network::Detection> found,
                                               const network::PixelBox& box, std::size_t labels);

// Every kind that may be said, with a label that means it.
[[nodiscard]] std::map<std::string, std::string> labels_of_proposals();

// A proposal and all that its pictures say.
struct ScoredProposal {
  Proposal proposal;
  std::vector<ProposalView> views;
  std::vector<ClassScores> said;  // by view
};

struct ProposalClass {
  std::size_t proposal = 0;  // index of ScoredProposal
  std::string word;
  double score = 0;  // mean over its views
};
// What proposals are called: the kind that their views make most probable in the mean. Of proposals
// of one kind that share three in ten of the smaller one's cells only the surest is told. By index.
[[nodiscard]] std::vector<ProposalClass> classify_proposals(std::span<const ScoredProposal> looked);

}  // namespace roomwise::objects
