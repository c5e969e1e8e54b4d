#include "rooms/rooms_options.h"

namespace roomwise::app {

void add_selection_options(CLI::App& command, SelectionOptions& options) {
  command.add_option("--visits", options.visits,
                     "Which visits of a room: 1, 2- or 1-3; default: all");
  command.add_option("--rooms", options.rooms, "Which rooms, separated by commas; default: all")
      ->delimiter(',');
}

Expected<pipeline::RoomSelection> parse(const SelectionOptions& options) {
  pipeline::RoomSelection selection;
  selection.rooms = options.rooms;
  if (!options.visits.empty()) {
    ROOMWISE_TRY(selection.stays, pipeline::parse_stays(options.visits));
  }
  return selection;
}

}  // namespace roomwise::app
