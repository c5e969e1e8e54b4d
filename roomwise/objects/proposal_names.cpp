#include "roomwise/objects/proposal_names.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "roomwise/image/resample.h"
#include "roomwise/objects/crop_regions.h"
#include "roomwise/objects/kind_shape.h"
#include "roomwise/objects/world_sight.h"

namespace roomwise::objects {
namespace {

using network::PixelBox;

constexpr int kVersion = 1;  // counted up where the same networks say other things
constexpr float kClassifierMargin = 1.15F, kDetectorMargin = 1.4F;  // in longest sides of the box
constexpr float kLeastDetection = 0.15F;
constexpr float kSameBox = 0.5F;  // a detection that covers the proposal's box so well is of it

// What ImageNet's classifiers call rightly in such pictures (docs/objects.md). Of the others either
// they have no plain word (bed, chair, sofa) or say little.
const std::set<std::string>& words_of_classifier() {
  static const std::set<std::string> kWords{
      "bath",  "bookcase", "chair",       "lamp", "microwave", "radiator",       "sink",
      "table", "toaster",  "toilet seat", "tv",   "wardrobe",  "washing machine"};
  return kWords;
}
// Lamps are vases to COCO's detectors, and so is much that is small; toasters they never say.
bool is_asked_of_detector(const std::string& word) {
  static const std::set<std::string> kMistaken{"bottle", "clock", "toaster", "vase"};
  return !kMistaken.contains(word);
}

// ImageNet has some of them only: dining tables and desks, folding and rocking chairs. Of these the
// classifier does not speak against what the detector says.
bool is_partly_known(const std::string& word) {
  return word == "chair" || word == "table";
}

std::optional<std::string> word_of(const std::string& label) {
  static const auto words = ObjectVocabulary::standard();
  static const auto look_alikes = ObjectVocabulary::look_alikes();
  if (auto word = words.object_of(label)) return word;
  return look_alikes.object_of(label);
}

// A part of the picture, and where in it a box of the picture lies.
struct Square {
  image::ColorImage picture;
  float left_px = 0, top_px = 0;
};
Square cut_out(const image::ColorImage& picture, const PixelBox& box, float margin) {
  const PixelBox square = square_about(box, margin, picture.width(), picture.height());
  const int side = static_cast<int>(square.right - square.left);
  return {
      image::crop(picture, static_cast<int>(square.left), static_cast<int>(square.top), side, side),
      square.left, square.top};
}

// The mean over the views, of each word that one of them says.
WordScores mean_of(std::span<const WordScores> said) {
  WordScores mean;
  for (const WordScores& view : said) {
    for (const auto& [word, score] : view) mean[word] += score / static_cast<double>(said.size());
  }
  return mean;
}

// The word that is said most, of those that the proposal is as large as.
std::optional<ProposalName> best_name(std::size_t index, const LookedProposal& looked) {
  constexpr std::size_t kFewestViews = 3;
  constexpr double kLeastScore = 0.3;
  if (looked.views.size() < kFewestViews) return std::nullopt;
  ProposalName best{.proposal = index, .word = {}, .score = 0};
  for (const auto& [word, score] : mean_of(looked.said)) {
    if (score < kLeastScore || score <= best.score) continue;
    if (!shape_of(word).holds_what_is_seen(looked.proposal.box_world.size_m)) continue;
    best.word = word;
    best.score = score;
  }
  return best.score > 0 ? std::optional(best) : std::nullopt;
}

// The cells of a proposal, sorted.
std::vector<VoxelKey> cells_of(const LookedProposal& looked) {
  constexpr float kCell_m = 0.05F;
  return voxels_of(looked.proposal.surface_world, kCell_m);
}

// The share of the smaller one's cells that both have.
double shared(std::span<const VoxelKey> a, std::span<const VoxelKey> b) {
  std::vector<VoxelKey> both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return static_cast<double>(both.size()) / static_cast<double>(std::min(a.size(), b.size()));
}

// The names of proposals that are all called by one word, without those that are a part of another
// one or hold more than it.
std::vector<ProposalName> each_once(std::vector<ProposalName> named,
                                    std::span<const LookedProposal> looked) {
  constexpr double kAsSurely = 0.75;
  constexpr double kShared = 0.3;  // of the smaller one's cells
  std::ranges::stable_sort(named, std::greater{}, &ProposalName::score);
  std::vector<std::vector<VoxelKey>> cells;
  for (const ProposalName& one : named) cells.push_back(cells_of(looked[one.proposal]));
  std::vector<bool> is_done(named.size(), false);
  std::vector<ProposalName> kept;
  for (std::size_t surest = 0; surest < named.size(); ++surest) {
    if (is_done[surest]) continue;
    std::size_t whole = surest;
    for (std::size_t i = surest; i < named.size(); ++i) {
      if (is_done[i] || shared(cells[surest], cells[i]) < kShared) continue;
      const bool is_as_sure = named[i].score >= kAsSurely * named[surest].score;
      if (is_as_sure && cells[i].size() > cells[whole].size()) whole = i;
    }
    kept.push_back(named[whole]);
    for (std::size_t i = surest; i < named.size(); ++i) {
      is_done[i] = is_done[i] || shared(cells[surest], cells[i]) >= kShared ||
                   shared(cells[whole], cells[i]) >= kShared;
    }
  }
  return kept;
}

class NetworkNamer final : public ProposalNamer {
 public:
  NetworkNamer(std::shared_ptr<const network::Detector> detector,
               std::shared_ptr<const network::Classifier> classifier)
      : detector_(std::move(detector)), classifier_(std::move(classifier)) {
    std::set<std::string> detected;
    for (const std::string& label : detector_->labels()) {
      const auto word = word_of(label);
      const bool is_asked = word && is_asked_of_detector(*word);
      word_of_detection_.push_back(is_asked ? *word : "");
      if (is_asked) detected.insert(*word);
      if (is_asked) words_.emplace(*word, label);
    }
    for (const std::string& label : classifier_->labels()) {
      const auto word = word_of(label);
      const bool is_asked = word && words_of_classifier().contains(*word);
      word_of_class_.push_back(is_asked ? *word : "");
      if (is_asked && detected.contains(*word)) asked_of_both_.insert(*word);
      if (is_asked) words_.emplace(*word, label);
    }
    fingerprint_ = fmt::format("{}{}{} {}: {}; {}", classifier_->fingerprint(), kProposalMethod,
                               kVersion, detector_->fingerprint(), classifier_->preprocessing(),
                               fmt::join(words_, ", "));
  }

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::map<std::string, std::string>& words() const override { return words_; }
  [[nodiscard]] Expected<WordScores> look(const image::ColorImage& picture,
                                          const PixelBox& box) const override {
    if (picture.empty()) return fail("a picture without pixels shows nothing");
    ROOMWISE_TRY(WordScores scores, said_by_classifier(picture, box));
    ROOMWISE_TRY(const WordScores detected, said_by_detector(picture, box));
    for (const auto& [word, score] : detected) scores[word] += score;
    for (auto& [word, score] : scores) {
      if (!asked_of_both_.contains(word)) continue;
      score /= 2;
      const auto own = detected.find(word);
      if (own != detected.end() && is_partly_known(word)) score = std::max(score, own->second);
    }
    return scores;
  }

 private:
  [[nodiscard]] Expected<WordScores> said_by_classifier(const image::ColorImage& picture,
                                                        const PixelBox& box) const {
    ROOMWISE_TRY(const network::Prediction said,
                 classifier_->predict(cut_out(picture, box, kClassifierMargin).picture));
    WordScores scores;
    for (std::size_t i = 0; i < said.scores.size(); ++i) {
      if (!word_of_class_[i].empty()) {
        scores[word_of_class_[i]] += static_cast<double>(said.scores[i]);
      }
    }
    return scores;
  }

  [[nodiscard]] Expected<WordScores> said_by_detector(const image::ColorImage& picture,
                                                      const PixelBox& box) const {
    const Square square = cut_out(picture, box, kDetectorMargin);
    ROOMWISE_TRY(const auto found, detector_->detect(square.picture, kLeastDetection));
    WordScores scores;
    for (const network::Detection& detection : found) {
      const std::string& word = word_of_detection_[detection.label];
      if (word.empty()) continue;
      PixelBox there = detection.box;
      there.left += square.left_px;
      there.right += square.left_px;
      there.top += square.top_px;
      there.bottom += square.top_px;
      if (network::intersection_over_union(there, box) < kSameBox) continue;
      double& score = scores[word];
      score = std::max(score, static_cast<double>(detection.score));
    }
    return scores;
  }

  std::shared_ptr<const network::Detector> detector_;
  std::shared_ptr<const network::Classifier> classifier_;
  std::vector<std::string> word_of_class_, word_of_detection_;  // by label; empty: not asked
  std::set<std::string> asked_of_both_;
  std::map<std::string, std::string> words_;
  std::string name_ = "closer looks", fingerprint_;
};

}  // namespace

std::unique_ptr<ProposalNamer> network_namer(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier) {
  return std::make_unique<NetworkNamer>(std::move(detector), std::move(classifier));
}

std::vector<ProposalName> name_proposals(std::span<const LookedProposal> looked) {
  std::map<std::string, std::vector<ProposalName>> of_word;
  for (std::size_t i = 0; i < looked.size(); ++i) {
    if (auto named = best_name(i, looked[i])) of_word[named->word].push_back(*std::move(named));
  }
  std::vector<ProposalName> names;
  for (auto& [word, named] : of_word) {
    std::ranges::move(each_once(std::move(named), looked), std::back_inserter(names));
  }
  std::ranges::sort(names, {}, &ProposalName::proposal);
  return names;
}

}  // namespace roomwise::objects
