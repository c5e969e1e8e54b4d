#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace roomwise {

// Where long work tells how far it is. The library only reports; what is shown is the caller's
// choice.
class Progress {
 public:
  virtual ~Progress() = default;
  // A new piece of work begins ("mapping"); total is absent where it cannot be known (a live
  // camera).
  virtual void begin(std::string_view work, std::optional<std::uint64_t> total) = 0;
  // `done` units of it are finished; `note` is a short remark on the state ("212 key-frames, 9
  // loops").
  virtual void advance(std::uint64_t done, std::string_view note) = 0;
  virtual void end() = 0;
  // True once the user asked to stop; the work then saves what it has and returns.
  [[nodiscard]] virtual bool interrupted() const { return false; }
};

// Says nothing.
class SilentProgress final : public Progress {
 public:
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
};

}  // namespace roomwise
