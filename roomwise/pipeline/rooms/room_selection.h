#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/recording/room_labels.h"

namespace roomwise::pipeline {

// Visits first to last of a room, both included; no last: all from the first on.
struct VisitSpan {
  int first = 1;
  std::optional<int> last;

  friend bool operator==(const VisitSpan&, const VisitSpan&) = default;
};

// Which parts of a labelled recording are meant. Empty lists mean all.
struct RoomSelection {
  std::vector<VisitSpan> visits;
  std::vector<std::string> rooms;

  [[nodiscard]] bool contains(const recording::RoomRange& range) const;
  // Fails, naming it, where a room is selected that the labels do not have.
  [[nodiscard]] Expected<void> check_against(const recording::RoomLabels& labels) const;
};

// "1", "2-", "1-3", "1,4-": visits are counted from 1.
[[nodiscard]] Expected<std::vector<VisitSpan>> parse_visits(std::string_view text);

}  // namespace roomwise::pipeline
