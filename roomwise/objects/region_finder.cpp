#include "roomwise/objects/region_finder.h"

#include <utility>

namespace roomwise::objects {
namespace {

class DetectorRegions final : public RegionFinder {
 public:
  DetectorRegions(std::string name, std::shared_ptr<const network::Detector> detector,
                  float least_score)
      : name_(std::move(name)), detector_(std::move(detector)), least_score_(least_score) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return detector_->fingerprint(); }
  [[nodiscard]] const std::vector<std::string>& labels() const override {
    return detector_->labels();
  }
  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    return detector_->detect(picture, least_score_);
  }

 private:
  std::string name_;
  std::shared_ptr<const network::Detector> detector_;
  float least_score_;
};

}  // namespace

RegionSource source_of(std::string_view fingerprint) {
  if (fingerprint.find(kActivationMethod) != std::string_view::npos)
    return RegionSource::kActivation;
  return fingerprint.find(kCropMethod) != std::string_view::npos ? RegionSource::kCrop
                                                                 : RegionSource::kDetector;
}

std::unique_ptr<RegionFinder> detector_regions(std::string name,
                                               std::shared_ptr<const network::Detector> detector,
                                               float least_score) {
  return std::make_unique<DetectorRegions>(std::move(name), std::move(detector), least_score);
}

}  // namespace roomwise::objects
