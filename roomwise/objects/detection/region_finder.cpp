#include "roomwise/objects/detection/region_finder.h"

#include <utility>

namespace roomwise::objects {
namespace {

class DetectorFinder final : public DetectionFinder {
 public:
  DetectorFinder(std::string name, std::shared_ptr<const network::Detector> detector,
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

std::unique_ptr<DetectionFinder> detector_finder(std::string name,
                                                 std::shared_ptr<const network::Detector> detector,
                                                 float min_score) {
  return std::make_unique<DetectorFinder>(std::move(name), std::move(detector), min_score);
}

}  // namespace roomwise::objects
