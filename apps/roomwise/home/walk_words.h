#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "roomwise/home/home.h"

namespace roomwise::app {

// What the walks of a home are called, and when they were. Two of one name are told apart by their
// number.
class WalkWords {
 public:
  [[nodiscard]] static Expected<WalkWords> of(const home::Home& home);

  [[nodiscard]] const std::string& name(home::RecordingId walk) const { return names_.at(walk); }
  // "3 May 2026 at 10 o'clock", by the time zone of this computer; absent where a stamp does not
  // tell the date.
  [[nodiscard]] std::optional<std::string> date(TimestampNs timestamp_ns) const;

 private:
  std::map<home::RecordingId, std::string> names_;
  std::vector<std::string> months_;
};

// "2026-05-03T10", by the time zone of this computer; null where a stamp does not tell the date.
[[nodiscard]] Json date_json(TimestampNs timestamp_ns);

}  // namespace roomwise::app
