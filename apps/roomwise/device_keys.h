#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::app {

// What a person asks the device by a key.
struct KeyRequest {
  enum class Kind { kWhere, kAround, kFind, kFindNext, kWay, kRepeat, kQuiet, kExit };
  Kind kind = Kind::kWhere;
  std::string thing;  // of kFind and kWay

  bool operator==(const KeyRequest&) const = default;
};

// Letters as they come from a keyboard or a pipe: w (where am I), a (around me), f NAME Enter
// (find), g NAME Enter (go there), r (repeat), q (quiet), x (exit). Others mean nothing.
class TypedKeys {
 public:
  [[nodiscard]] std::vector<KeyRequest> take(std::string_view bytes);

 private:
  bool naming_ = false;  // after f or g, until Enter
  KeyRequest::Kind named_kind_ = KeyRequest::Kind::kFind;
  std::string name_;
};

// Events of a Linux input device (struct input_event), in pieces of any size: the keys 1 (where am
// I), 2 (around me), 3 (find the next thing of the home), 4 (repeat), 5 (quiet), when they go down.
class ButtonEvents {
 public:
  [[nodiscard]] std::vector<KeyRequest> take(std::span<const std::uint8_t> bytes);

 private:
  std::vector<std::uint8_t> rest_;
};

// Both, as they come in. While it lives, a terminal gives each key at once and does not show it.
class DeviceKeys {
 public:
  // `keyboard`: a descriptor, standard input, or -1. `buttons`: /dev/input/eventN, or empty. Fails
  // where they cannot be read.
  [[nodiscard]] static Expected<std::unique_ptr<DeviceKeys>> open(
      int keyboard, const std::filesystem::path& buttons);
  ~DeviceKeys();
  DeviceKeys(const DeviceKeys&) = delete;
  DeviceKeys& operator=(const DeviceKeys&) = delete;

  // What was asked since the last call; waits for it, but no longer than so many milliseconds.
  [[nodiscard]] std::vector<KeyRequest> wait(int most_ms);

 private:
  DeviceKeys() = default;

  struct Terminal;  // its settings as they were
  std::unique_ptr<Terminal> terminal_;
  TypedKeys typed_;
  ButtonEvents events_;
  int keyboard_ = -1;  // descriptors; -1 where there is none (any more)
  int buttons_ = -1;
};

}  // namespace roomwise::app
