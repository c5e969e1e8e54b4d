#include "roomwise/pipeline/rooms/room_selection.h"

#include <algorithm>
#include <charconv>

namespace roomwise::pipeline {
namespace {

std::optional<int> parse_visit(std::string_view text) {
  int visit = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), visit);
  if (error != std::errc() || end != text.data() + text.size() || visit < 1) return std::nullopt;
  return visit;
}

std::optional<VisitSpan> parse_span(std::string_view text) {
  const std::size_t dash = text.find('-');
  const auto first = parse_visit(text.substr(0, dash));
  if (!first) return std::nullopt;
  if (dash == std::string_view::npos) return VisitSpan{*first, first};
  if (dash + 1 == text.size()) return VisitSpan{*first, std::nullopt};
  const auto last = parse_visit(text.substr(dash + 1));
  if (!last || *last < *first) return std::nullopt;
  return VisitSpan{*first, last};
}

}  // namespace

bool RoomSelection::contains(const recording::RoomRange& range) const {
  const bool visit_selected =
      visits.empty() || std::ranges::any_of(visits, [&](const VisitSpan& span) {
        return range.visit >= span.first && (!span.last || range.visit <= *span.last);
      });
  return visit_selected && (rooms.empty() || std::ranges::count(rooms, range.room) > 0);
}

Expected<void> RoomSelection::check_against(const recording::RoomLabels& labels) const {
  for (const std::string& room : rooms) {
    if (std::ranges::count(labels.ranges(), room, &recording::RoomRange::room) == 0) {
      return fail("the recording's labels have no room '{}'", room);
    }
  }
  return {};
}

Expected<std::vector<VisitSpan>> parse_visits(std::string_view text) {
  std::vector<VisitSpan> visits;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const auto span = parse_span(rest.substr(0, comma));
    if (!span) return fail("'{}' are no visits; expected for example 1, 2- or 1-3", text);
    visits.push_back(*span);
    if (comma == std::string_view::npos) return visits;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace roomwise::pipeline
