#include "typed_room.h"

#include <poll.h>
#include <unistd.h>

#include <sstream>

#include "roomwise/recording/room_labels.h"

namespace roomwise::app {
namespace {

// The words of a line, divided by single blanks.
std::string words_of(const std::string& line) {
  std::istringstream words(line);
  std::string joined;
  for (std::string word; words >> word;) joined += (joined.empty() ? "" : " ") + word;
  return joined;
}

}  // namespace

bool TypedRoom::take(std::optional<std::string>& room, TerminalProgress& progress) {
  bool was_typed = false;
  while (const auto line = next_line()) {
    const std::string name = words_of(*line);
    const auto valid = name.empty() ? Expected<void>() : recording::validate_room_name(name);
    if (!valid) {
      progress.note(valid.error().message + "; the room stays as it was");
      continue;
    }
    room = name.empty() ? std::nullopt : std::optional(name);
    was_typed = true;
  }
  return was_typed;
}

std::optional<std::string> TypedRoom::next_line() {
  while (ready()) read_some();
  const std::size_t end = typed_.find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::string line = typed_.substr(0, end);
  typed_.erase(0, end + 1);
  return line;
}

bool TypedRoom::ready() const {
  pollfd input{descriptor_, POLLIN, 0};
  return ::poll(&input, 1, 0) > 0;
}

void TypedRoom::read_some() {
  char buffer[256];
  const ssize_t got = ::read(descriptor_, buffer, sizeof buffer);
  if (got <= 0) {
    descriptor_ = -1;
  } else {
    typed_.append(buffer, static_cast<std::size_t>(got));
  }
}

}  // namespace roomwise::app
