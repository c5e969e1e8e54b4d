#pragma once

#include <string>
#include <utility>
#include <vector>

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

}  // namespace roomwise::pipeline::testing
