#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise::app {

// The file of the user's own kinds of things (objects::add_kinds()): the one that ROOMWISE_KINDS
// names, else kinds.json in $XDG_DATA_HOME/roomwise or ~/.local/share/roomwise; empty where there
// is none.
[[nodiscard]] std::filesystem::path own_kinds_file();

// Adds them, if any. Fails, naming the file and the row, where ROOMWISE_KINDS names no file or one
// is wrong.
[[nodiscard]] Expected<void> add_own_kinds();

}  // namespace roomwise::app
