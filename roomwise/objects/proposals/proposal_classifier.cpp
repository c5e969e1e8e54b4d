#include "roomwise/objects/proposals/proposal_classifier.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

#include "roomwise/image/resample.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "roomwise/objects/proposals/cell_components.h"
#include "roomwise/objects/proposals/square_about.h"

namespace roomwise::objects {
namespace {

using network::PixelBox;

// Sides of the squares that networks are shown, in longest sides of the box: as much about a thing
// as pictures that they learned from have.
constexpr float kClassifierCropMargin = 1.15F, kDetectorCropMargin = 1.4F;
constexpr float kMinDetection = 0.15F;  // below, a detector says next to nothing
constexpr float kSameBox = 0.5F;        // intersection over union

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

class NetworkClassifier final : public ProposalClassifier {
 public:
  NetworkClassifier(std::shared_ptr<const network::Detector> detector,
                    std::shared_ptr<const network::Classifier> classifier)
      : detector_(std::move(detector)),
        classifier_(std::move(classifier)),
        detected_(detector_->labels(), standard_kinds()),
        classified_(classifier_->labels(), standard_kinds()) {}

  [[nodiscard]] Expected<ClassScores> look(const image::ColorImage& picture, const PixelBox& box,
                                           const Proposal& thing) const override {
    if (picture.empty()) return fail("a picture without pixels shows nothing");
    ROOMWISE_TRY(const network::Prediction said,
                 classifier_->predict(cut_out(picture, box, kClassifierCropMargin).picture));
    const Square square = cut_out(picture, box, kDetectorCropMargin);
    ROOMWISE_TRY(auto found, detector_->detect(square.picture, kMinDetection));
    for (network::Detection& detection : found) {
      detection.box.left += square.left_px;
      detection.box.right += square.left_px;
      detection.box.top += square.top_px;
      detection.box.bottom += square.top_px;
    }
    ClassScores scores = classified_.scores(said.scores, thing);
    const auto labels = labels_of_box(found, box, detector_->labels().size());
    for (const auto& [kind, score] : detected_.scores(labels, thing)) {
      scores[kind] = std::max(scores[kind], score);
    }
    return scores;
  }

 private:
  std::shared_ptr<const network::Detector> detector_;
  std::shared_ptr<const network::Classifier> classifier_;
  KindsOfLabels detected_, classified_;
};

// How dense such sizes are among things of a kind; of none, evenly.
double density_of(const Kind* kind, const Proposal& thing) {
  static const double kOfAny = std::pow(std::log(4 / 0.02), -3);
  if (kind == nullptr || !kind->size) return kOfAny;
  const Eigen::Vector3d& box_m = thing.box_world.size_m;
  const auto [shorter_m, longer_m] = std::minmax(box_m.x(), box_m.y());
  // The foot of what stands on the floor may be hidden.
  const double height_m = kind->stands_on_floor ? std::max(box_m.z(), thing.top_m) : box_m.z();
  return std::exp(kind->size->log_density({longer_m, shorter_m, height_m}));
}

// The kind that is most probable in the mean of the views.
std::optional<ProposalClass> best_class(std::size_t index, const ScoredProposal& looked) {
  ClassScores sums;
  for (const ClassScores& view : looked.said) {
    for (const auto& [kind, score] : view) sums[kind] += score;
  }
  ProposalClass best{.proposal = index, .word = {}, .score = 0};
  for (const auto& [kind, sum] : sums) {
    const double score = sum / static_cast<double>(looked.said.size());
    if (!(score > best.score)) continue;  // nor what is no number
    best.word = kind;
    best.score = score;
  }
  return best.score > 0 ? std::optional(std::move(best)) : std::nullopt;
}

bool share_cells(std::span<const VoxelKey> a, std::span<const VoxelKey> b) {
  constexpr double kMin = 0.3;  // of the smaller one's
  std::vector<VoxelKey> both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return static_cast<double>(both.size()) >=
         kMin * static_cast<double>(std::min(a.size(), b.size()));
}

}  // namespace

KindsOfLabels::KindsOfLabels(std::span<const std::string> labels, std::span<const Kind> kinds) {
  for (const std::string& label : labels) {
    std::vector<const Kind*>& meant = of_label_.emplace_back();
    for (const Kind& kind : kinds) {
      const auto is_label = [&](const std::string& own) { return same_label(label, own); };
      if (std::ranges::any_of(kind.labels, is_label)) meant.push_back(&kind);
    }
  }
}

ClassScores KindsOfLabels::scores(std::span<const float> said, const Proposal& thing) const {
  ClassScores scores;
  for (std::size_t label = 0; label < said.size(); ++label) {
    std::vector<double> densities;
    double sum = density_of(nullptr, thing);
    for (const Kind* kind : of_label_[label]) {
      sum += densities.emplace_back(density_of(kind, thing));
    }
    for (std::size_t i = 0; i < densities.size(); ++i) {
      scores[of_label_[label][i]->name] += static_cast<double>(said[label]) * densities[i] / sum;
    }
  }
  return scores;
}

std::vector<float> labels_of_box(std::span<const network::Detection> found, const PixelBox& box,
                                 std::size_t labels) {
  std::vector<float> scores(labels, 0);
  for (const network::Detection& detection : found) {
    if (network::intersection_over_union(detection.box, box) < kSameBox) continue;
    scores[detection.label] = std::max(scores[detection.label], detection.score);
  }
  return scores;
}

std::unique_ptr<ProposalClassifier> network_proposal_classifier(
    std::shared_ptr<const network::Detector> detector,
    std::shared_ptr<const network::Classifier> classifier) {
  return std::make_unique<NetworkClassifier>(std::move(detector), std::move(classifier));
}

std::map<std::string, std::string> labels_of_proposals() {
  std::map<std::string, std::string> labels;
  for (const Kind& kind : standard_kinds()) {
    if (!kind.labels.empty()) labels[kind.name] = kind.labels.front();
  }
  return labels;
}

std::vector<ProposalClass> classify_proposals(std::span<const ScoredProposal> looked) {
  std::vector<ProposalClass> all;
  for (std::size_t i = 0; i < looked.size(); ++i) {
    if (auto best = best_class(i, looked[i])) all.push_back(*std::move(best));
  }
  std::ranges::stable_sort(all, std::greater{}, &ProposalClass::score);
  std::vector<ProposalClass> kept;
  std::map<std::string, std::vector<std::vector<VoxelKey>>> cells_of_kind;
  for (ProposalClass& one : all) {
    auto& known = cells_of_kind[one.word];
    const auto cells = voxels_of(looked[one.proposal].proposal.surface_world, kLevelCell_m);
    if (std::ranges::any_of(known, [&](const auto& of) { return share_cells(of, cells); }))
      continue;
    known.push_back(cells);
    kept.push_back(std::move(one));
  }
  std::ranges::sort(kept, {}, &ProposalClass::proposal);
  return kept;
}

}  // namespace roomwise::objects
