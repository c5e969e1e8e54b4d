#include "roomwise/objects/proposals/proposal_classifier.h"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "roomwise/image/resample.h"
#include "roomwise/objects/instances/world_observation.h"
#include "roomwise/objects/proposals/cell_components.h"
#include "roomwise/objects/proposals/class_size_prior.h"
#include "roomwise/objects/proposals/square_about.h"

namespace roomwise::objects {
namespace {

using network::PixelBox;

constexpr float kClassifierCropMargin = 1.15F,
                kDetectorCropMargin = 1.4F;  // in longest sides of the box
constexpr float kMinDetection = 0.15F;
constexpr float kSameBox = 0.5F;  // a detection that covers the proposal's box so well is of it

// What ImageNet's classifiers call rightly in such pictures (docs/objects.md). For others they have
// no word (bed, sofa), or say little.
const std::set<std::string>& words_of_classifier() {
  static const std::set<std::string> kWords{
      "bath",  "bookcase", "chair",       "lamp", "microwave", "radiator",       "sink",
      "table", "toaster",  "toilet seat", "tv",   "wardrobe",  "washing machine"};
  return kWords;
}
// What ImageNet calls what holds books, or flowers, as often as a bookcase and a vase. Of a piece
// of known size it means these.
std::string_view word_of_like(std::string_view label) {
  static constexpr std::array<std::string_view, 2> kCases{"china cabinet, china closet",
                                                          "entertainment center"};
  static constexpr std::array<std::string_view, 12> kVessels{
      "vase",   "bucket, pail", "coffee mug",    "cup",       "goblet",  "milk can",
      "mortar", "mixing bowl",  "pitcher, ewer", "soup bowl", "thimble", "water jug"};
  if (std::ranges::find(kCases, label) != kCases.end()) return "bookcase";
  return std::ranges::find(kVessels, label) != kVessels.end() ? "vase" : "";
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

// The words that things may get, and look-alikes.
const ObjectVocabulary& all_words() {
  static const ObjectVocabulary kWords = [] {
    ObjectVocabulary words = ObjectVocabulary::standard();
    const ObjectVocabulary look_alikes = ObjectVocabulary::look_alikes();
    for (const auto& [word, labels] : look_alikes.objects()) {
      std::ignore = words.add(word, {labels.begin(), labels.end()});  // no label is in both
    }
    return words;
  }();
  return kWords;
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
ClassScores mean_of(std::span<const ClassScores> said) {
  ClassScores mean;
  for (const ClassScores& view : said) {
    for (const auto& [word, score] : view) mean[word] += score / static_cast<double>(said.size());
  }
  return mean;
}

double shorter_m(const Proposal& proposal) {
  return proposal.box_world.size_m.head<2>().minCoeff();
}
double longer_m(const Proposal& proposal) {
  return proposal.box_world.size_m.head<2>().maxCoeff();
}

// And neither hangs nor stands on something.
bool stands_on_floor(const Proposal& proposal) {
  constexpr double kFoot_m = 0.25;
  return proposal.box_world.size_m.z() >= proposal.top_m - kFoot_m;
}

constexpr double kWardrobeTop_m = 1.8;

// What is wider than doors are is none, though little of its depth was seen.
bool is_front_of_wardrobe(const Proposal& proposal) {
  constexpr double kWiderThanDoors_m = 1.4, kThinnest_m = 0.2;
  return stands_on_floor(proposal) && proposal.top_m >= kWardrobeTop_m &&
         longer_m(proposal) >= kWiderThanDoors_m && shorter_m(proposal) >= kThinnest_m;
}

// As large as vases mostly are: cups are smaller, bowls lower, bins stand on the floor.
bool is_like_a_vase(const Proposal& proposal) {
  constexpr double kMinSide_m = 0.18, kMaxSide_m = 0.4, kMin_m = 0.2, kMax_m = 0.5;
  constexpr double kOnFloor_m = 0.3;
  const double height_m = proposal.box_world.size_m.z();
  return shorter_m(proposal) >= kMinSide_m && longer_m(proposal) <= kMaxSide_m &&
         height_m >= kMin_m && height_m <= kMax_m && proposal.top_m - height_m > kOnFloor_m;
}

// By its size; of what stands on the floor the height is that of its top.
bool may_be(const Proposal& proposal, const ClassSizePrior& shape) {
  Eigen::Vector3d whole_m = proposal.box_world.size_m;
  if (shape.on_floor) whole_m.z() = std::max(whole_m.z(), proposal.top_m);
  const bool is_seen_so = shape.fits_when_partial(proposal.box_world.size_m) ||
                          (shape.name == "wardrobe" && is_front_of_wardrobe(proposal));
  return is_seen_so && shape.holds(whole_m) && (shape.name != "vase" || is_like_a_vase(proposal));
}

// Networks see of a table what lies on it, of a chair its legs, and take a sofa for a bed; few
// other things have their form, but large plants have a table's in their midst.
void add_form(const Proposal& proposal, ClassScores& scores) {
  constexpr double kForm = 0.4, kAmongPlants = 0.1;
  if (proposal.form == FurnitureForm::kTable && scores["plant"] < kAmongPlants) {
    scores["table"] += kForm;
  }
  if (proposal.form == FurnitureForm::kChair) scores["chair"] += kForm;
  if (proposal.form == FurnitureForm::kSofa) {
    scores["sofa"] += kForm + scores["bed"];
    scores.erase("bed");
  }
}

// The score of a word, which then is not said any more; 0 where it was not.
double take(const std::string& word, ClassScores& scores) {
  const auto said = scores.find(word);
  if (said == scores.end() || !(said->second > 0)) return 0;  // nor what is no number
  const double score = said->second;
  scores.erase(said);
  return score;
}

// What looks like a fridge to a detector and is thinner than any is a bookcase, though a classifier
// calls it a wardrobe; and so is what is thinner and narrower than either. What is wider than any
// fridge is a wardrobe. Of what touches a wall a hand's breadth was taken away with it, so that a
// fridge may be 0.5 m thick.
void add_case(const Proposal& proposal, ClassScores& scores) {
  constexpr double kMinFridge = 0.1;
  constexpr double kBookcaseTop_m = 1.5, kThinnest_m = 0.25, kThickest_m = 0.42, kNarrow_m = 0.62;
  constexpr double kWardrobeThinnest_m = 0.4, kWardrobeThickest_m = 0.95;
  if (!stands_on_floor(proposal)) return;
  const auto fridge = scores.find("fridge");
  const bool looks_so = fridge != scores.end() && fridge->second >= kMinFridge;
  const double thick_m = shorter_m(proposal);
  const double max_m = size_prior_of("fridge").max_length_at(proposal.box_world.size_m.z());
  const bool is_wider = longer_m(proposal) > max_m;
  const bool is_narrow = longer_m(proposal) <= kNarrow_m;
  if ((looks_so || is_narrow) && !is_wider && proposal.top_m >= kBookcaseTop_m &&
      thick_m >= kThinnest_m && thick_m <= kThickest_m) {
    const double called_others = take("fridge", scores) + take("wardrobe", scores);
    if (called_others > 0) scores["bookcase"] += called_others;
  } else if (looks_so && is_wider && proposal.top_m >= kWardrobeTop_m &&
             thick_m >= kWardrobeThinnest_m && thick_m <= kWardrobeThickest_m) {
    scores["wardrobe"] += take("fridge", scores);
  }
}

// The word that is said most, of those that the proposal is as large as.
std::optional<ProposalClass> best_name(std::size_t index, const ScoredProposal& looked) {
  constexpr std::size_t kFewestViews = 3;
  constexpr double kMinScore = 0.3;
  if (looked.views.size() < kFewestViews) return std::nullopt;
  ProposalClass best{.proposal = index, .word = {}, .score = 0};
  ClassScores scores = mean_of(looked.said);
  add_form(looked.proposal, scores);
  add_case(looked.proposal, scores);
  for (const auto& [word, sum] : scores) {
    const double score = std::min(sum, 1.0);
    if (!(score >= kMinScore && score > best.score)) continue;  // nor what is no number
    if (!may_be(looked.proposal, size_prior_of(word))) continue;
    best.word = word;
    best.score = score;
  }
  return best.score > 0 ? std::optional(best) : std::nullopt;
}

// The cells of a proposal, sorted.
std::vector<VoxelKey> cells_of(const ScoredProposal& looked) {
  return voxels_of(looked.proposal.surface_world, kLevelCell_m);
}

// Whether both have enough of the smaller one's cells.
bool share_a_thing(std::span<const VoxelKey> a, std::span<const VoxelKey> b) {
  constexpr double kMin = 0.3;
  std::vector<VoxelKey> both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return static_cast<double>(both.size()) >=
         kMin * static_cast<double>(std::min(a.size(), b.size()));
}

// By one word what is so alike that a part of it is often called by the name of another.
std::string family_of(const std::string& word) {
  if (word == "sofa") return "bed";
  if (word == "bookcase" || word == "fridge") return "wardrobe";
  return word;
}

// The names of proposals that are called alike, without those that are a part of another one or
// hold more than it.
std::vector<ProposalClass> without_parts(std::vector<ProposalClass> named,
                                         std::span<const ScoredProposal> looked) {
  constexpr double kAsSurely = 0.75;
  std::ranges::stable_sort(named, std::greater{}, &ProposalClass::score);
  std::vector<std::vector<VoxelKey>> cells;
  for (const ProposalClass& one : named) cells.push_back(cells_of(looked[one.proposal]));
  std::vector<bool> is_done(named.size(), false);
  std::vector<ProposalClass> kept;
  for (std::size_t surest = 0; surest < named.size(); ++surest) {
    if (is_done[surest]) continue;
    std::size_t whole = surest;
    for (std::size_t i = surest; i < named.size(); ++i) {
      if (is_done[i] || !share_a_thing(cells[surest], cells[i])) continue;
      const bool is_as_sure = named[i].score >= kAsSurely * named[surest].score;
      if (is_as_sure && cells[i].size() > cells[whole].size()) whole = i;
    }
    kept.push_back(named[whole]);
    for (std::size_t i = surest; i < named.size(); ++i) {
      is_done[i] = is_done[i] || share_a_thing(cells[surest], cells[i]) ||
                   share_a_thing(cells[whole], cells[i]);
    }
  }
  return kept;
}

// The same for each family.
std::vector<ProposalClass> without_parts_of_families(std::span<const ProposalClass> named,
                                                     std::span<const ScoredProposal> looked) {
  std::map<std::string, std::vector<ProposalClass>> of_family;
  for (const ProposalClass& one : named) of_family[family_of(one.word)].push_back(one);
  std::vector<ProposalClass> kept;
  for (auto& [family, of_one] : of_family) {
    std::ranges::move(without_parts(std::move(of_one), looked), std::back_inserter(kept));
  }
  return kept;
}

class NetworkNamer final : public ProposalClassifier {
 public:
  NetworkNamer(std::shared_ptr<const network::Detector> detector,
               std::shared_ptr<const network::Classifier> classifier)
      : detector_(std::move(detector)), classifier_(std::move(classifier)) {
    std::set<std::string> detected;
    for (const std::string& label : detector_->labels()) {
      const auto word = all_words().object_of(label);
      const bool is_asked = word && is_asked_of_detector(*word);
      word_of_detection_.push_back(is_asked ? *word : "");
      if (is_asked) detected.insert(*word);
    }
    for (const std::string& label : classifier_->labels()) {
      const auto word = all_words().object_of(label);
      const bool is_asked = word && words_of_classifier().contains(*word);
      word_of_class_.emplace_back(is_asked ? *word : word_of_like(label));
      if (is_asked && detected.contains(*word)) asked_of_both_.insert(*word);
    }
  }

  [[nodiscard]] Expected<ClassScores> look(const image::ColorImage& picture,
                                           const PixelBox& box) const override {
    if (picture.empty()) return fail("a picture without pixels shows nothing");
    ROOMWISE_TRY(const network::Prediction said,
                 classifier_->predict(cut_out(picture, box, kClassifierCropMargin).picture));
    ClassScores by_classifier;
    for (std::size_t i = 0; i < said.scores.size(); ++i) {
      if (word_of_class_[i].empty()) continue;
      by_classifier[word_of_class_[i]] += static_cast<double>(said.scores[i]);
    }
    const Square square = cut_out(picture, box, kDetectorCropMargin);
    ROOMWISE_TRY(auto found, detector_->detect(square.picture, kMinDetection));
    for (network::Detection& detection : found) {
      detection.box.left += square.left_px;
      detection.box.right += square.left_px;
      detection.box.top += square.top_px;
      detection.box.bottom += square.top_px;
    }
    return join_scores(by_classifier, scores_of(found, box, word_of_detection_), asked_of_both_);
  }

 private:
  std::shared_ptr<const network::Detector> detector_;
  std::shared_ptr<const network::Classifier> classifier_;
  std::vector<std::string> word_of_class_, word_of_detection_;  // by label; empty: not asked
  std::set<std::string> asked_of_both_;
};

}  // namespace

std::unique_ptr<ProposalClassifier> network_proposal_classifier(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier) {
  return std::make_unique<NetworkNamer>(std::move(detector), std::move(classifier));
}

std::map<std::string, std::string> labels_of_proposals() {
  std::map<std::string, std::string> labels;
  for (const auto& [word, of_word] : all_words().objects()) labels[word] = *of_word.begin();
  return labels;
}

ClassScores scores_of(std::span<const network::Detection> found, const PixelBox& box,
                      std::span<const std::string> word_of_label) {
  ClassScores scores;
  for (const network::Detection& detection : found) {
    const std::string& word = word_of_label[detection.label];
    if (word.empty() || network::intersection_over_union(detection.box, box) < kSameBox) continue;
    double& score = scores[word];
    score = std::max(score, static_cast<double>(detection.score));
  }
  return scores;
}

ClassScores join_scores(const ClassScores& by_classifier, const ClassScores& by_detector,
                        const std::set<std::string>& asked_of_both) {
  ClassScores scores = by_classifier;
  for (const auto& [word, score] : by_detector) scores[word] += score;
  for (auto& [word, score] : scores) {
    if (!asked_of_both.contains(word)) continue;
    score /= 2;
    const auto own = by_detector.find(word);
    if (own != by_detector.end() && is_partly_known(word)) score = std::max(score, own->second);
  }
  return scores;
}

std::vector<ProposalClass> classify_proposals(std::span<const ScoredProposal> looked) {
  std::vector<ProposalClass> apart, cut;
  for (std::size_t i = 0; i < looked.size(); ++i) {
    if (auto named = best_name(i, looked[i])) {
      (looked[i].proposal.is_cut ? cut : apart).push_back(*std::move(named));
    }
  }
  std::vector<ProposalClass> names = without_parts_of_families(apart, looked);
  std::vector<std::vector<VoxelKey>> known;
  for (const ProposalClass& one : names) known.push_back(cells_of(looked[one.proposal]));
  std::erase_if(cut, [&](const ProposalClass& one) {
    const std::vector<VoxelKey> cells = cells_of(looked[one.proposal]);
    return std::ranges::any_of(known,
                               [&](const auto& other) { return share_a_thing(cells, other); });
  });
  std::ranges::move(without_parts_of_families(cut, looked), std::back_inserter(names));
  std::ranges::sort(names, {}, &ProposalClass::proposal);
  return names;
}

}  // namespace roomwise::objects
