#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/network/vision/classifier.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/objects/proposals/proposals.h"

namespace roomwise::objects {

// What one picture of a proposal says for each word, [0, 1]; words that nothing speaks for may be
// missing.
using ClassScores = std::map<std::string, double>;

// Says what a box of a picture shows, in words of the standard table or look-alikes. look() may be
// called from several threads at once.
class ProposalClassifier {
 public:
  virtual ~ProposalClassifier() = default;

  [[nodiscard]] virtual Expected<ClassScores> look(const image::ColorImage& picture,
                                                   const network::PixelBox& box) const = 0;
};

// Shows the square about the box to a detector and to a classifier, large and in the middle, as
// they want it: what is small or far in a whole picture, or fills it, is named so. Each is asked
// for the words that it says rightly of such squares (docs/objects.md).
[[nodiscard]] std::unique_ptr<ProposalClassifier> network_proposal_classifier(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier);

// Every word that may be said, with a label that means it.
[[nodiscard]] std::map<std::string, std::string> labels_of_proposals();

// What a detector says of a box: by word, the best of the detections that overlap it by half.
// `word_of_label` in the order of the detector's labels, empty for what is not asked.
[[nodiscard]] ClassScores scores_of(std::span<const network::Detection> found,
                                    const network::PixelBox& box,
                                    std::span<const std::string> word_of_label);
// A word that both are asked for gets the mean of what they say, so that either alone is believed
// by half; chairs and tables what the detector says, where that is more.
[[nodiscard]] ClassScores join_scores(const ClassScores& by_classifier,
                                      const ClassScores& by_detector,
                                      const std::set<std::string>& asked_of_both);

// A proposal and all that its pictures say.
struct ScoredProposal {
  Proposal proposal;
  std::vector<ProposalView> views;
  std::vector<ClassScores> said;  // by view
};

struct ProposalClass {
  std::size_t proposal = 0;  // index of ScoredProposal
  std::string word;
  double score = 0;  // mean over its views, and what its form adds; 1 at most
};
// What proposals are called: the word that their views say most in the mean, with what their form
// adds (FurnitureForm), of those that such things are as large as (ClassSizePrior). Of proposals of
// one word, or of words that are taken for each other, that share cells only one is; what is cut
// from what it touches gives way to what stands apart. By index.
[[nodiscard]] std::vector<ProposalClass> classify_proposals(std::span<const ScoredProposal> looked);

}  // namespace roomwise::objects
