#pragma once

#include <string>
#include <utility>
#include <vector>

#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/objects/proposals/proposal_classifier.h"

namespace roomwise::pipeline::testing {

// What a test's finder is called and may say; what it finds is the test's.
class FakeFinder : public objects::DetectionFinder {
 public:
  FakeFinder(std::string name, std::vector<std::string> labels)
      : name_(std::move(name)), labels_(std::move(labels)) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }

 private:
  std::string name_;
  std::vector<std::string> labels_;
};

// Looks, and finds nothing.
class BlindFinder final : public FakeFinder {
 public:
  BlindFinder() : FakeFinder("blind", {"couch"}) {}

  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage&) const override {
    return std::vector<network::Detection>{};
  }
};

// Says that what is red in the middle is a lamp.
class RedProposalClassifier final : public objects::ProposalClassifier {
 public:
  bool fails = false;
  std::string word = "lamp";

  [[nodiscard]] Expected<objects::ClassScores> look(const image::ColorImage& picture,
                                                    const network::PixelBox& box,
                                                    const objects::Proposal&) const override {
    if (fails) return fail("the classifier sees nothing");
    const Rgb8 middle = picture.at(static_cast<int>((box.left + box.right) / 2),
                                   static_cast<int>((box.top + box.bottom) / 2));
    const bool is_red = middle.r > 240 && middle.g < 10 && middle.b < 10;
    return is_red ? objects::ClassScores{{word, 0.8}} : objects::ClassScores{};
  }
};

}  // namespace roomwise::pipeline::testing
