#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/recording/room_labels.h"

namespace roomwise::pipeline {

// Stays first to last in a room, both included; no last: all from the first on.
struct StaySpan {
  int first = 1;
  std::optional<int> last;

  friend bool operator==(const StaySpan&, const StaySpan&) = default;
};

// Which parts of a labelled recording are meant. Empty lists mean all.
struct RoomSelection {
  std::vector<StaySpan> stays;
  std::vector<std::string> rooms;

  [[nodiscard]] bool contains(const recording::RoomRange& range) const;
  // Fails, naming it, where a room is selected that the labels do not have.
  [[nodiscard]] Expected<void> check_against(const recording::RoomLabels& labels) const;
};

// "1", "2-", "1-3", "1,4-": stays are counted from 1.
[[nodiscard]] Expected<std::vector<StaySpan>> parse_stays(std::string_view text);

}  // namespace roomwise::pipeline
