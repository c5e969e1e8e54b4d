#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "roomwise/base/progress.h"

namespace roomwise::pipeline::testing {

// The user stops as soon as some work begins.
class InterruptedAt final : public Progress {
 public:
  explicit InterruptedAt(std::string work) : work_(std::move(work)) {}

  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    has_begun_ = has_begun_ || work == work_;
  }
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return has_begun_; }

 private:
  std::string work_;
  bool has_begun_ = false;
};

}  // namespace roomwise::pipeline::testing
