#include "roomwise/pipeline/rooms/room_selection.h"

#include <algorithm>
#include <charconv>

namespace roomwise::pipeline {
namespace {

std::optional<int> parse_stay(std::string_view text) {
  int stay = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), stay);
  if (error != std::errc() || end != text.data() + text.size() || stay < 1) return std::nullopt;
  return stay;
}

std::optional<StaySpan> parse_span(std::string_view text) {
  const std::size_t dash = text.find('-');
  const auto first = parse_stay(text.substr(0, dash));
  if (!first) return std::nullopt;
  if (dash == std::string_view::npos) return StaySpan{*first, first};
  if (dash + 1 == text.size()) return StaySpan{*first, std::nullopt};
  const auto last = parse_stay(text.substr(dash + 1));
  if (!last || *last < *first) return std::nullopt;
  return StaySpan{*first, last};
}

}  // namespace

bool RoomSelection::contains(const recording::RoomRange& range) const {
  const bool stay_selected =
      stays.empty() || std::ranges::any_of(stays, [&](const StaySpan& span) {
        return range.stay >= span.first && (!span.last || range.stay <= *span.last);
      });
  return stay_selected && (rooms.empty() || std::ranges::count(rooms, range.room) > 0);
}

Expected<void> RoomSelection::check_against(const recording::RoomLabels& labels) const {
  for (const std::string& room : rooms) {
    if (std::ranges::count(labels.ranges(), room, &recording::RoomRange::room) == 0) {
      return fail("the recording's labels have no room '{}'", room);
    }
  }
  return {};
}

Expected<std::vector<StaySpan>> parse_stays(std::string_view text) {
  std::vector<StaySpan> stays;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const auto span = parse_span(rest.substr(0, comma));
    if (!span) return fail("'{}' are no visits; expected for example 1, 2- or 1-3", text);
    stays.push_back(*span);
    if (comma == std::string_view::npos) return stays;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace roomwise::pipeline
