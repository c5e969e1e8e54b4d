#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise {

// What long work asks now and then, on any of its threads, whether to stop. Work that was stopped
// keeps what it has and fails with ErrorCode::kInterrupted; where what it has is of use to the
// caller, it returns that instead, with `finished` false.
class Interruption {
 public:
  virtual ~Interruption() = default;
  [[nodiscard]] virtual bool interrupted() const { return false; }
  // Fails with "interrupted while WORK" where the work is to stop.
  [[nodiscard]] Expected<void> check(std::string_view work) const {
    if (!interrupted()) return {};
    return fail_with(ErrorCode::kInterrupted, "interrupted while {}", work);
  }
};

// Where long work tells how far it is. The library only reports; what is shown is the caller's
// choice.
class Progress : public Interruption {
 public:
  // A new piece of work begins ("mapping"); total is absent where it cannot be known (a live
  // camera).
  virtual void begin(std::string_view work, std::optional<std::uint64_t> total) = 0;
  // `done` units of it are finished; `note` is a short remark on the state ("212 key-frames, 9
  // loops").
  virtual void advance(std::uint64_t done, std::string_view note) = 0;
  virtual void end() = 0;
};

// Says nothing.
class SilentProgress final : public Progress {
 public:
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
};

}  // namespace roomwise
