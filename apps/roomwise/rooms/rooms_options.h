#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "roomwise/pipeline/rooms/room_selection.h"

namespace roomwise::app {

// Which parts of a recording, as the user says it.
struct SelectionOptions {
  std::string visits;
  std::vector<std::string> rooms;
};

// Declares --visits and --rooms.
void add_selection_options(CLI::App& command, SelectionOptions& options);
[[nodiscard]] Expected<pipeline::RoomSelection> parse(const SelectionOptions& options);

// "rooms eval".
void add_rooms_eval_command(CLI::App& group, Context& context);

}  // namespace roomwise::app
