#pragma once

#include <string>
#include <utility>
#include <vector>

#include "roomwise/objects/proposal_names.h"
#include "roomwise/objects/region_finder.h"

namespace roomwise::pipeline::testing {

// What a test's finder of regions is called and may say; what it finds is the test's.
class MadeUpFinder : public objects::RegionFinder {
 public:
  MadeUpFinder(std::string name, std::vector<std::string> labels)
      : name_(std::move(name)), labels_(std::move(labels)) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return name_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }

 private:
  std::string name_;
  std::vector<std::string> labels_;
};

// Looks, and finds nothing.
class BlindFinder final : public MadeUpFinder {
 public:
  BlindFinder() : MadeUpFinder("blind", {"couch"}) {}

  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage&) const override {
    return std::vector<network::Detection>{};
  }
};

// Says that what is red in the middle is a lamp.
class RedNamer final : public objects::ProposalNamer {
 public:
  bool fails = false;
  std::string word = "lamp";

  [[nodiscard]] Expected<objects::WordScores> look(const image::ColorImage& picture,
                                                   const network::PixelBox& box) const override {
    if (fails) return fail("the namer sees nothing");
    const Rgb8 middle = picture.at(static_cast<int>((box.left + box.right) / 2),
                                   static_cast<int>((box.top + box.bottom) / 2));
    const bool is_red = middle.r > 240 && middle.g < 10 && middle.b < 10;
    return is_red ? objects::WordScores{{word, 0.8}} : objects::WordScores{};
  }
};

}  // namespace roomwise::pipeline::testing
