#pragma once

#include <optional>
#include <string>

#include "terminal_progress.h"

namespace roomwise::app {

// The rooms that a person types while work goes on: a name and Enter, Enter alone for no named
// room.
class TypedRoom {
 public:
  // What is typed there is read; -1: nothing is.
  explicit TypedRoom(int descriptor) : descriptor_(descriptor) {}

  // Makes `room` the one that was typed last and gives whether one was, without waiting. What can
  // be no room's name is told to `progress` and changes nothing.
  bool take(std::optional<std::string>& room, TerminalProgress& progress);

 private:
  std::optional<std::string> next_line();
  [[nodiscard]] bool ready() const;
  void read_some();

  int descriptor_;
  std::string typed_;
};

}  // namespace roomwise::app
