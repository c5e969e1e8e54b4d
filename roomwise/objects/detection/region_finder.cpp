#include "roomwise/objects/detection/region_finder.h"

#include <utility>

namespace roomwise::objects {
namespace {

class DetectorRegions final : public RegionFinder {
 public:
  DetectorRegions(std::string name, std::shared_ptr<const network::Detector> detector,
                  float min_score)
      : name_(std::move(name)), detector_(std::move(detector)), min_score_(min_score) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return detector_->fingerprint(); }
  [[nodiscard]] const std::vector<std::string>& labels() const override {
    return detector_->labels();
  }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    return detector_->detect(picture, min_score_);
  }

 private:
  std::string name_;
  std::shared_ptr<const network::Detector> detector_;
  float min_score_;
};

}  // namespace

RegionSource source_of(std::string_view fingerprint) {
  const auto is_by = [&](std::string_view method) {
    return fingerprint.find(method) != std::string_view::npos;
  };
  if (is_by(kActivationMethod)) return RegionSource::kActivation;
  if (is_by(kCropMethod)) return RegionSource::kCrop;
  return is_by(kProposalMethod) ? RegionSource::kProposal : RegionSource::kDetector;
}

std::unique_ptr<RegionFinder> detector_regions(std::string name,
                                               std::shared_ptr<const network::Detector> detector,
                                               float min_score) {
  return std::make_unique<DetectorRegions>(std::move(name), std::move(detector), min_score);
}

}  // namespace roomwise::objects
